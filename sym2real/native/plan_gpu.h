/* One thread per sample for the whole horizon; torch weighs the costs and averages the actions. */
EXPORTED void __launch_bounds__(128) plan_samples(const struct plan plan, real *tracks, real *draws) {
    const struct plan *p = &plan;
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= p->samples) return;
    const TRACK track = {tracks + i, p->samples}, drawn = {draws + i, p->samples};
    if (p->noise) {
        for (int h = 0; h < p->horizon; h++)
            for (int a = 0; a < ACTIONS; a++) AT(track, h, a) = p->noise[(i * p->horizon + h) * ACTIONS + a];
    } else {
        draw_noise(p, (words)i, track, drawn);
        for (int h = 0; i == 0 && h < p->horizon; h++)
            for (int a = 0; a < ACTIONS; a++) AT(track, h, a) = 0.0f;
    }
    to_actions(p, track);
    p->costs[i] = total_cost(p, track);
}
