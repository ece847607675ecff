/* Layers of a residual network for the BLOCKS vectors of samples that go along the horizon together. Weights lie in
 * tiles of outputs of one size, its biases, then its weights input by input, so that they stream through the cache once
 * for all blocks; a tile's sums stay in registers, and each weight that is read is used BLOCKS times. */
#define TILES(outputs) (((outputs) + TILE - 1) / TILE)
#define ROOM(outputs) ((outputs) + TILES(outputs)) /* of whole tiles */
#define AHEAD 384 /* numbers: weights and layers together leave the first-level cache; measured, twice as fast */
INLINE const real *layer(const real *w, const v *x, int inputs, v *y, int outputs, int last) {
    const int tile = (outputs + TILES(outputs) - 1) / TILES(outputs);
    for (int j = 0; j < outputs; j += tile) {
        v sum[TILE][BLOCKS];
UNROLLED
        for (int t = 0; t < tile; t++)
UNROLLED
            for (int b = 0; b < BLOCKS; b++) sum[t][b] = splat(w[t]);
        w += tile;
        for (int i = 0; i < inputs; i++, w += tile) {
            const v *in = x + i * BLOCKS;
            PREFETCH(w + AHEAD);
UNROLLED
            for (int t = 0; t < tile; t++) {
                const v weight = splat(w[t]);
UNROLLED
                for (int b = 0; b < BLOCKS; b++) sum[t][b] = in[b] * weight + sum[t][b];
            }
        }
UNROLLED
        for (int t = 0; t < tile; t++)
UNROLLED
            for (int b = 0; b < BLOCKS; b++)
                y[(j + t) * BLOCKS + b] = last ? sum[t][b] : maximum(sum[t][b], splat(R(0.0)));
    }
    return w;
}
