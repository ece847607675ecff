/* Many rollouts with broadcast operands: where the numbers of each sample of a block lie. */
#define DIMENSIONS 8

struct operand {
    const real *data;
    long long batch[DIMENSIONS], step, column; /* strides */
};
struct batch {
    struct operand state, actions, inputs, parameters;
    real *out; /* (horizon, state, count) */
    long long sizes[DIMENSIONS], count, horizon, per_step;
};

APART void find_offsets(const struct batch *b, const struct operand *o, long long first, long long *offsets) {
    EACH_LANE {
        long long left = first + lane < b->count ? first + lane : b->count - 1, offset = 0;
        for (int d = DIMENSIONS - 1; d >= 0; d--) {
            offset += left % b->sizes[d] * o->batch[d];
            left /= b->sizes[d];
        }
        offsets[lane] = offset;
    }
}
/* Apart: inlined once per column, they would take longer to compile than all equations. */
APART v gather(const real *data, const long long *offsets) {
    v r;
    EACH_LANE r[lane] = data[offsets[lane]];
    return r;
}
APART void scatter(const struct batch *b, long long row, long long first, v x) {
    real *to = b->out + row * b->count + first;
    const long long most = b->count - first;
    if (most >= WIDTH)
        __builtin_memcpy(to, &x, sizeof x);
    else
        __builtin_memcpy(to, &x, most * sizeof(real));
}
