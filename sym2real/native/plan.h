/* One step of MPPI for one block of samples: noise, rollout, cost. ACTIONS, COLOUR and DIAGONAL are defined before.
 *
 * COLOUR: 0 white, 1 first-order correlated, 2 draws through the matrix `smooth`. */
struct plan {
    const real *state, *inputs, *reference, *memory, *weights;
    const real *mean, *low, *high, *factor, *smooth, *price, *noise;
    real *costs;
    real temperature, correlation;
    word seed, call;
    int samples, horizon, draws, begun;
};

/* Noise of a block into its track; the first sample has none, so that the mean itself is among the candidates. */
INLINE void colour(const struct plan *p, TRACK track, int step, const v *normals, v *past) {
    for (int a = 0; a < ACTIONS; a++) {
        v coloured = normals[a];
#if COLOUR == 1
        const real kept = p->correlation;
        const v fresh = step ? coloured * OF_REAL(sqrt)(R(1.0) - kept * kept) : coloured;
        coloured = past[a] = step ? past[a] * kept + fresh : fresh;
#endif
        AT(track, step, a) = coloured;
    }
}
#if COLOUR == 2
INLINE void through_matrix(const struct plan *p, TRACK track, TRACK drawn) {
    for (int h = 0; h < p->horizon; h++)
        for (int a = 0; a < ACTIONS; a++) {
            v sum = splat(R(0.0));
            for (int k = 0; k < p->draws; k++) sum += AT(drawn, k, a) * p->smooth[h * p->draws + k];
            AT(track, h, a) = sum;
        }
}
#endif
APART void draw_noise(const struct plan *p, words sample, TRACK track, TRACK drawn) {
    struct stream s = stream_of(sample, p->seed, p->call);
    v past[ACTIONS], normals[ACTIONS];
    const TRACK first = COLOUR == 2 ? drawn : track;
    for (int step = 0; step < p->draws; step++) {
        draw_normals(&s, ACTIONS, normals);
        colour(p, first, step, normals, past);
    }
#if COLOUR == 2
    through_matrix(p, track, drawn);
#endif
    for (int h = 0; h < p->horizon; h++) {
        v row[ACTIONS];
        for (int a = 0; a < ACTIONS; a++) {
            row[a] = AT(track, h, a) * p->factor[a * ACTIONS + a];
#if !DIAGONAL
            for (int b = 0; b < a; b++) row[a] += AT(track, h, b) * p->factor[a * ACTIONS + b];
#endif
        }
        for (int a = 0; a < ACTIONS; a++) AT(track, h, a) = row[a];
    }
}
/* Noise → actions within the limits. */
INLINE void to_actions(const struct plan *p, TRACK track) {
    for (int h = 0; h < p->horizon; h++)
        for (int a = 0; a < ACTIONS; a++) {
            const v wished = AT(track, h, a) + p->mean[h * ACTIONS + a];
            AT(track, h, a) = minimum(maximum(wished, splat(p->low[a])), splat(p->high[a]));
        }
}
/* Information-theoretic price of the noise; price is λ Σ^-1 of the mean, (horizon, actions). */
INLINE v price_of(const struct plan *p, TRACK track) {
    v sum = splat(R(0.0));
    if (p->price)
        for (int h = 0; h < p->horizon; h++)
            for (int a = 0; a < ACTIONS; a++)
                sum += (AT(track, h, a) - p->mean[h * ACTIONS + a]) * p->price[h * ACTIONS + a];
    return sum;
}
