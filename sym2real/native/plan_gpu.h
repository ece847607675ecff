/* One thread per sample for the whole horizon; torch weights the costs and averages the actions. */
INLINE void fill_noise(const struct plan *p, int i, TRACK track, TRACK drawn) {
    if (p->noise) {
        for (int h = 0; h < p->horizon; h++)
            for (int a = 0; a < ACTIONS; a++) AT(track, h, a) = p->noise[(i * p->horizon + h) * ACTIONS + a];
    } else {
        draw_noise(p, (words)i, track, drawn);
        for (int h = 0; i == 0 && h < p->horizon; h++)
            for (int a = 0; a < ACTIONS; a++) AT(track, h, a) = 0.0f;
    }
}
EXPORTED void __launch_bounds__(128) plan_samples(const struct plan plan, real *tracks, real *draws) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= plan.samples) return;
    const TRACK track = {tracks + i, plan.samples}, drawn = {draws + i, plan.samples};
    fill_noise(&plan, i, track, drawn);
    to_actions(&plan, track);
    plan.costs[i] = total_cost(&plan, track);
}
EXPORTED void __launch_bounds__(128) noise_of(const struct plan plan, real *tracks, real *draws) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= plan.samples) return;
    const TRACK track = {tracks + i, plan.samples}, drawn = {draws + i, plan.samples};
    fill_noise(&plan, i, track, drawn);
}
