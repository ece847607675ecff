/* Vectors of samples on a processor, by GCC's and Clang's vector extensions; SINGLE says whether they hold float32.
 *
 * cuda.h gives the same names for the one sample of a thread. */
#if defined(__AVX512F__)
#define BYTES 64
#define TILE 16 /* outputs whose sums a layer of a network keeps in registers */
#elif defined(__AVX__)
#define BYTES 32
#else
#define BYTES 16
#endif
#if !defined(TILE)
#define TILE 12
#endif
#define UNROLLED _Pragma("GCC unroll 16")
#define ROLLED
#if SINGLE
typedef float real;
typedef int integer;
typedef unsigned int word;
#define R(x) x##f
#define OF_REAL(name) __builtin_##name##f
#else
typedef double real;
typedef long long integer;
typedef unsigned long long word;
#define R(x) x
#define OF_REAL(name) __builtin_##name
#endif
#define WIDTH ((int)(BYTES / sizeof(real)))
typedef real v __attribute__((vector_size(BYTES)));
typedef integer mask __attribute__((vector_size(BYTES)));
typedef word words __attribute__((vector_size(BYTES)));

#define INLINE static inline __attribute__((always_inline))
#define APART static __attribute__((noinline))
#define EXPORTED __attribute__((visibility("default")))
#define EACH_LANE for (int lane = 0; lane < WIDTH; lane++)
#define LANE(x) ((x)[lane])
#define NOT(c) (~(c))
#define INFINITE OF_REAL(inf)()
typedef v *TRACK; /* (steps, actions) of the samples of a block */
#define AT(track, h, a) ((track)[(h) * ACTIONS + (a)])

INLINE v splat(real x) { return x - (v){0}; }
INLINE v select(mask c, v a, v b) { return (v)((c & (mask)a) | (~c & (mask)b)); }
INLINE v square_root(v a) {
    v r;
    EACH_LANE r[lane] = OF_REAL(sqrt)(a[lane]);
    return r;
}
INLINE v nearest(v a) {
    v r;
    EACH_LANE r[lane] = OF_REAL(rint)(a[lane]);
    return r;
}
#if defined(__AVX512DQ__) && SINGLE && defined(__has_builtin)
#if __has_builtin(__builtin_ia32_reduceps512_mask_round)
#define HAS_REDUCE 1 /* one instruction for two; 5 % of an action */
#endif
#endif
#if defined(HAS_REDUCE)
INLINE v less_nearest(v a) { return (v)__builtin_ia32_reduceps512_mask_round(a, 0, a, -1, 4); }
#else
INLINE v less_nearest(v a) { return a - nearest(a); }
#endif
INLINE v reciprocal_root(v a) { return splat(R(1.0)) / square_root(a); }
INLINE v minimum(v a, v b) { return select((b < a) | (b != b), b, a); } /* NaN of either stays, as in torch */
INLINE v maximum(v a, v b) { return select((a < b) | (b != b), b, a); }
INLINE v to_reals(words a) { return __builtin_convertvector((mask)a, v); }
INLINE words bits_of(v a) { return (words)a; }
INLINE v from_bits(words a) { return (v)a; }
#if SINGLE
INLINE v two_to_the(v k) { return (v)((__builtin_convertvector(k, mask) + 127) << 23); }
#endif
