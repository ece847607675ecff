/* All samples of one thread, block by block, and the weighted mean of their actions in one pass: the sums are scaled
 * down whenever a cheaper rollout appears. */
struct share {
    real least, total;
    int rejected, unused;
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
/* Adds a block to the sums of its thread. */
INLINE void weigh(const struct plan *p, int first, v costs, TRACK track, v *sums, v *total, struct share *share) {
    real least = share->least;
    EACH_LANE {
        if (first + lane >= p->samples) {
            costs[lane] = INFINITE;
            continue;
        }
        const real cost = costs[lane];
        if (!(cost - cost == R(0.0))) {
            costs[lane] = INFINITE;
            share->rejected++;
        } else if (cost < least)
            least = cost;
        p->costs[first + lane] = cost;
    }
    const int count = p->horizon * ACTIONS;
    if (least < share->least) {
        if (share->least < INFINITE) {
            const v kept = exponential(splat((least - share->least) / p->temperature));
            *total *= kept;
            for (int i = 0; i < count; i++) sums[i] *= kept;
        }
        share->least = least;
    }
    if (!(share->least < INFINITE)) return;
    v weight = exponential((share->least - costs) / p->temperature);
    EACH_LANE if (!(costs[lane] < INFINITE)) weight[lane] = R(0.0);
    *total += weight;
    for (int i = 0; i < count; i++) sums[i] += weight * track[i];
}
EXPORTED int width(void) { return WIDTH; }

/* Samples first … last - 1 (first a multiple of the width); scratch: 3 tracks; sums: (horizon, actions)
 * numbers. */
EXPORTED void plan_share(const struct plan *p, int first, int last, v *scratch, real *out, struct share *share) {
    const int count = p->horizon * ACTIONS;
    v *track = scratch, *drawn = scratch + count, *sums = drawn + p->draws * ACTIONS;
    v total = splat(R(0.0));
    *share = (struct share){INFINITE, R(0.0), 0, 0};
    for (int i = 0; i < count; i++) sums[i] = total;
    for (int at = first; at < last; at += WIDTH) {
        fill_noise(p, at, track, drawn);
        to_actions(p, track);
        weigh(p, at, total_cost(p, track), track, sums, &total, share);
    }
    EACH_LANE share->total += total[lane];
    for (int i = 0; i < count; i++) {
        out[i] = R(0.0);
        EACH_LANE out[i] += sums[i][lane];
    }
}
/* A mean as it stands some steps later; its last row is repeated. */
EXPORTED void shifted(const struct plan *p, const real *before, int steps, real *mean) {
    for (int h = 0; h < p->horizon; h++) {
        const int from = h + steps < p->horizon ? h + steps : p->horizon - 1;
        for (int a = 0; a < ACTIONS; a++) mean[h * ACTIONS + a] = before[from * ACTIONS + a];
    }
}
/* Weighted mean of all threads' sums (threads, horizon, actions); the mean stays where no rollout was finite. */
EXPORTED int finish(const struct plan *p, int threads, const real *sums, const struct share *shares, real *mean) {
    const int count = p->horizon * ACTIONS;
    real least = INFINITE, total = R(0.0);
    int rejected = 0;
    for (int t = 0; t < threads; t++) {
        rejected += shares[t].rejected;
        if (shares[t].least < least) least = shares[t].least;
    }
    if (!(least < INFINITE)) return rejected;
    for (int i = 0; i < count; i++) mean[i] = R(0.0);
    for (int t = 0; t < threads; t++) {
        if (!(shares[t].least < INFINITE)) continue;
        const real kept = OF_REAL(exp)((least - shares[t].least) / p->temperature);
        total += kept * shares[t].total;
        for (int i = 0; i < count; i++) mean[i] += kept * sums[t * count + i];
    }
    for (int i = 0; i < count; i++) mean[i] /= total;
    return rejected;
}
/* The noise that plan_share draws, (samples, horizon, actions). */
EXPORTED void noise_of(const struct plan *p, v *scratch, real *out) {
    const int count = p->horizon * ACTIONS;
    for (int at = 0; at < p->samples; at += WIDTH) {
        fill_noise(p, at, scratch, scratch + count);
        EACH_LANE if (at + lane < p->samples)
            for (int i = 0; i < count; i++) out[(at + lane) * count + i] = scratch[i][lane];
    }
}
