/* Layers of a residual network for a vector of samples. Weights lie in tiles of outputs of one size, its biases, then its
 * weights input by input: they stream through the cache once, and a tile's sums stay in registers. */
#define TILES(outputs) (((outputs) + TILE - 1) / TILE)
#define ROOM(outputs) ((outputs) + TILES(outputs)) /* of whole tiles */
INLINE const real *layer(const real *w, const v *x, int inputs, v *y, int outputs, int last) {
    const int tile = (outputs + TILES(outputs) - 1) / TILES(outputs);
    for (int j = 0; j < outputs; j += tile) {
        v sum[TILE];
UNROLLED
        for (int t = 0; t < tile; t++) sum[t] = splat(w[t]);
        w += tile;
ROLLED
        for (int i = 0; i < inputs; i++, w += tile) {
UNROLLED
            for (int t = 0; t < tile; t++) sum[t] = x[i] * w[t] + sum[t];
        }
UNROLLED
        for (int t = 0; t < tile; t++) y[j + t] = last ? sum[t] : maximum(sum[t], splat(R(0.0)));
    }
    return w;
}
