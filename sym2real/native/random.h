/* Normal numbers that depend on seed, call and sample alone, whatever the order, the threads and the width.
 *
 * Each sample has a stream of its own: C. Doty-Humphrey's sfc32 (PractRand), begun at a hash of the three numbers
 * (integer hash lowbias32 by C. Wellons). Pairs by G. E. P. Box and M. E. Muller, Ann. Math. Stat. 29, 1958, with a
 * radius from 24 bits (at most 5.9) and an angle from 16 to 23. */
struct stream {
    words a, b, c, counter;
};
INLINE words mixed(words x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}
INLINE words next_words(struct stream *s) {
    const words out = s->a + s->b + s->counter;
    s->counter += 1;
    s->a = s->b ^ (s->b >> 9);
    s->b = s->c + (s->c << 3);
    s->c = ((s->c << 21) | (s->c >> 11)) + out;
    return out;
}
INLINE struct stream stream_of(words sample, word seed, word call) {
    struct stream s;
    s.a = mixed(sample + seed);
    s.b = mixed(s.a ^ call);
    s.c = mixed(s.b + 0x9e3779b9u);
    s.counter = (sample ^ sample) + 1;
    for (int i = 0; i < 4; i++) next_words(&s);
    return s;
}
/* angle: 23 random bits, the highest ones first. */
INLINE void normal_pair(words radius, words angle, v *first, v *second) {
    const v u = (to_reals(radius >> 8) + 0.5f) * 5.9604645e-8f;
    const v exponent = to_reals(bits_of(u) >> 23);
    const v mantissa = from_bits((bits_of(u) & 0x7fffffu) | 0x3f800000u);
    const v r = square_root(maximum((127.0f - exponent - NORMAL_LOG2(mantissa)) * 1.38629436f, splat(0.0f)));
    const v t = from_bits((angle & 0x7fffffu) | 0x3f800000u) * 6.28318531f - 9.42477796f;
    const v s = t * t;
    *first = r * (t * NORMAL_SINE(s));
    *second = r * NORMAL_COSINE(s);
}
/* count normal numbers, into[0 … count - 1], count at most MOST_DRAWS and known at compilation. */
#define MOST_DRAWS 16
INLINE void draw_normals(struct stream *s, int count, v *into) {
    words angles = next_words(s);
    for (int i = 0; i < count; i += 2) {
        v first, second;
        if (i && i % 4 == 0) angles = next_words(s);
        normal_pair(next_words(s), i % 4 ? angles >> 9 : angles << 7, &first, &second);
        into[i] = first;
        if (i + 1 < count) into[i + 1] = second;
    }
}
