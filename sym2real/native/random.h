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
    s.a = mixed(sample + mixed((sample ^ sample) + seed)); /* sample + seed: neighbours would share all but one */
    s.b = mixed(s.a ^ call);
    s.c = mixed(s.b + 0x9e3779b9u);
    s.counter = (sample ^ sample) + 1;
    for (int i = 0; i < 4; i++) next_words(&s);
    return s;
}
/* A normal number for every action. Stage by stage, so that pairs are computed side by side:
 * -2 ln u = -2 ln 2 (log2 m + e) for u = m 2^e, and an angle of 23 bits or 16. */
#define PAIRS ((ACTIONS + 1) / 2)
INLINE void draw_normals(struct stream *s, v *into) {
    words radius[PAIRS], angle[PAIRS], shared;
    v square[PAIRS], turn[PAIRS];
    UNROLLED for (int i = 0; i < PAIRS; i++) {
        if (i % 2 == 0) shared = next_words(s);
        radius[i] = next_words(s);
        angle[i] = i % 2 ? shared >> 9 : shared << 7;
    }
    UNROLLED for (int i = 0; i < PAIRS; i++) radius[i] = bits_of(to_reals(radius[i] >> 8) + 0.5f);
    UNROLLED for (int i = 0; i < PAIRS; i++) {
        const v exponent = to_reals(radius[i] >> 23) - 151.0f; /* the integer above was 2^24 u */
        const v mantissa = from_bits((radius[i] & 0x7fffffu) | 0x3f800000u);
        square[i] = (exponent + LOGARITHM(mantissa)) * -1.38629436f;
    }
    UNROLLED for (int i = 0; i < PAIRS; i++) turn[i] = from_bits((angle[i] & 0x7fffffu) | 0x3f800000u) - 1.5f;
    UNROLLED for (int i = 0; i < PAIRS; i++) {
        const v r = square_root(maximum(square[i], splat(0.0f))), s = turn[i] * turn[i];
        into[2 * i] = r * (turn[i] * SINE(s));
        if (2 * i + 1 < ACTIONS) into[2 * i + 1] = r * COSINE(s);
    }
}
