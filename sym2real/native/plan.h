/* One step of MPPI for one block of samples: noise, rollout, cost. ACTIONS and COLOUR are defined before.
 *
 * What went before, in `memory` of the filters and `past` of a network, is there once something was sent: `begun`. States
 * that nobody measures lie in `hidden`, null where each sample's begin with its own first action.
 * COLOUR: 0 white, 1 first-order correlated, 2 draws through the matrix `smooth`. */
struct plan {
    const real *state, *inputs, *reference, *memory, *past, *hidden, *weights;
    const real *mean, *low, *high, *spread, *smooth, *noise;
    real *costs;
    real temperature, correlation, fresh; /* of a step that follows another: correlation² + fresh² = 1 */
    word seed, call;
    int samples, horizon, draws, begun;
};

/* Noise of a block into its track. */
APART void draw_noise(const struct plan *p, words sample, TRACK track, TRACK drawn) {
    struct stream s = stream_of(sample, p->seed, p->call);
    const TRACK into = COLOUR == 2 ? drawn : track;
    v row[ACTIONS], before[ACTIONS];
    for (int a = 0; a < ACTIONS; a++) before[a] = splat(R(0.0));
    for (int step = 0; step < p->draws; step++) {
        draw_normals(&s, row);
        for (int a = 0; a < ACTIONS; a++) {
            row[a] *= p->spread[a];
#if COLOUR == 1
            row[a] = step ? before[a] * p->correlation + row[a] * p->fresh : row[a];
            before[a] = row[a];
#endif
            AT(into, step, a) = row[a];
        }
    }
#if COLOUR == 2
    for (int h = 0; h < p->horizon; h++)
        for (int a = 0; a < ACTIONS; a++) {
            v sum = splat(R(0.0));
            for (int k = 0; k < p->draws; k++) sum += AT(drawn, k, a) * p->smooth[h * p->draws + k];
            AT(track, h, a) = sum;
        }
#endif
}
/* Noise → actions within the limits. */
INLINE void to_actions(const struct plan *p, TRACK track) {
    for (int h = 0; h < p->horizon; h++)
        for (int a = 0; a < ACTIONS; a++) {
            const v wished = AT(track, h, a) + p->mean[h * ACTIONS + a];
            AT(track, h, a) = minimum(maximum(wished, splat(p->low[a])), splat(p->high[a]));
        }
}
