/* What vectors.h says, for the one sample of a thread; float32. Tests give it to a C compiler, behind what CUDA has and C has not. */
#ifndef C_NAME
#define C_NAME extern "C"
#endif
typedef float real;
typedef unsigned int word;
typedef float v;
typedef int mask;
typedef unsigned int words;
typedef struct {
    real *at;
    int stride;
} TRACK; /* (steps, actions, samples): neighbours in a warp read neighbouring numbers */

#define WIDTH 1
#define TILE 16
#define UNROLLED _Pragma("unroll")
#define ROLLED _Pragma("unroll 1")
#define R(x) x##f
#define OF_REAL(name) name##f
#define INLINE static __device__ __forceinline__
#define APART static __device__ __noinline__
#define EXPORTED C_NAME __global__
#define EACH_LANE
#define LANE(x) (x)
#define NOT(c) (!(c))
#define INFINITE __uint_as_float(0x7f800000u)
#define AT(track, h, a) ((track).at[((h) * ACTIONS + (a)) * (track).stride])

INLINE v splat(real x) { return x; }
INLINE v select(mask c, v a, v b) { return c ? a : b; }
INLINE v square_root(v a) { return sqrtf(a); }
INLINE v nearest(v a) { return rintf(a); }
INLINE v less_nearest(v a) { return a - rintf(a); }
INLINE v reciprocal_root(v a) { return 1.0f / sqrtf(a); }
INLINE v minimum(v a, v b) { return b < a || b != b ? b : a; }
INLINE v maximum(v a, v b) { return a < b || b != b ? b : a; }
INLINE v to_reals(words a) { return (float)(int)a; }
INLINE words bits_of(v a) { return __float_as_uint(a); }
INLINE v from_bits(words a) { return __uint_as_float(a); }
INLINE v two_to_the(v k) { return __uint_as_float((unsigned int)((int)k + 127) << 23); }
