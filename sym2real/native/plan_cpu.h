/* All samples, block by block, and the weighted mean of their actions in one pass: the sums are scaled down whenever a
 * cheaper rollout appears. */
struct running {
    v total;
    real least;
    int rejected;
};

INLINE void given_noise(const struct plan *p, int first, TRACK track) {
    for (int h = 0; h < p->horizon; h++)
        for (int a = 0; a < ACTIONS; a++) {
            v r;
            EACH_LANE {
                const int i = first + lane < p->samples ? first + lane : p->samples - 1;
                r[lane] = p->noise[(i * p->horizon + h) * ACTIONS + a];
            }
            AT(track, h, a) = r;
        }
}
INLINE words samples_from(int first) {
    words r;
    EACH_LANE r[lane] = first + lane;
    return r;
}
static void fill_noise(const struct plan *p, int first, TRACK track, TRACK drawn) {
    if (p->noise) {
        given_noise(p, first, track);
        return;
    }
    draw_noise(p, samples_from(first), track, drawn);
    if (first == 0)
        for (int i = 0; i < p->horizon * ACTIONS; i++) track[i][0] = R(0.0);
}
/* Adds a block to the sums. */
INLINE void accumulate(const struct plan *p, int first, v costs, TRACK track, v *sums, struct running *running) {
    real least = running->least;
    EACH_LANE {
        if (first + lane >= p->samples) {
            costs[lane] = INFINITE;
            continue;
        }
        const real cost = costs[lane];
        if (!(cost - cost == R(0.0))) {
            costs[lane] = INFINITE;
            running->rejected++;
        } else if (cost < least)
            least = cost;
        p->costs[first + lane] = cost;
    }
    const int count = p->horizon * ACTIONS;
    if (least < running->least) {
        if (running->least < INFINITE) {
            const v kept = exponential(splat((least - running->least) / p->temperature));
            running->total *= kept;
            for (int i = 0; i < count; i++) sums[i] *= kept;
        }
        running->least = least;
    }
    if (!(running->least < INFINITE)) return;
    v weight = exponential((running->least - costs) / p->temperature);
    EACH_LANE if (!(costs[lane] < INFINITE)) weight[lane] = R(0.0);
    running->total += weight;
    for (int i = 0; i < count; i++) sums[i] += weight * track[i];
}
EXPORTED int width(void) { return WIDTH; }

/* A mean as it stands some steps later; its last row is repeated. */
EXPORTED void shifted(const struct plan *p, const real *before, int steps, real *mean) {
    for (int h = 0; h < p->horizon; h++) {
        const int from = h + steps < p->horizon ? h + steps : p->horizon - 1;
        for (int a = 0; a < ACTIONS; a++) mean[h * ACTIONS + a] = before[from * ACTIONS + a];
    }
}
/* The weighted mean of all samples, which stays where none was finite, and how many were not; scratch: 2 tracks and the
 * draws. */
EXPORTED int plan_all(const struct plan *p, v *scratch, real *mean) {
    const int count = p->horizon * ACTIONS;
    v *track = scratch, *drawn = scratch + count, *sums = drawn + p->draws * ACTIONS;
    struct running running = {splat(R(0.0)), INFINITE, 0};
    for (int i = 0; i < count; i++) sums[i] = running.total;
    for (int at = 0; at < p->samples; at += WIDTH) {
        fill_noise(p, at, track, drawn);
        to_actions(p, track);
        accumulate(p, at, total_cost(p, track), track, sums, &running);
    }
    if (!(running.least < INFINITE)) return running.rejected;
    real total = R(0.0);
    EACH_LANE total += running.total[lane];
    for (int i = 0; i < count; i++) {
        real sum = R(0.0);
        EACH_LANE sum += sums[i][lane];
        mean[i] = sum / total;
    }
    return running.rejected;
}
/* The noise that plan_all draws, (samples, horizon, actions). */
EXPORTED void noise_of(const struct plan *p, v *scratch, real *out) {
    const int count = p->horizon * ACTIONS;
    for (int at = 0; at < p->samples; at += WIDTH) {
        fill_noise(p, at, scratch, scratch + count);
        EACH_LANE if (at + lane < p->samples)
            for (int i = 0; i < count; i++) out[(at + lane) * count + i] = scratch[i][lane];
    }
}
