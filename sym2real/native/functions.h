/* The polynomials are printed by sym2real/symbolic/c_functions.py, with their errors. */
INLINE v reciprocal(v a) { return splat(R(1.0)) / a; }
INLINE v absolute(v a) { return select(a < splat(R(0.0)), -a, a); }
INLINE v sign_of(v a) {
    const v zero = splat(R(0.0));
    return select(zero < a, splat(R(1.0)), zero) - select(a < zero, splat(R(1.0)), zero);
}

/* Turns less whole turns; rounding their number costs no more than rounding x did. */
INLINE v part_of_turn(v x) {
    const v turns = x * R(0.15915494309189535);
    return less_nearest(turns);
}
INLINE v sine(v x) {
    const v part = part_of_turn(x);
    return part * SINE(part * part);
}
INLINE v cosine(v x) {
    const v part = part_of_turn(x);
    return COSINE(part * part);
}

#if SINGLE
APART v exponential(v x) {
    const v high = splat(88.3f), low = splat(-87.0f);
    const v in = select(high < x, high, select(x < low, low, x));
    const v k = nearest(in * 1.44269504f);
    const v f = ((in - k * 0.693145752f) - k * 1.42860677e-6f) * 1.44269504f;
    return select(high < x, splat(INFINITE), POWER_OF_TWO(f) * two_to_the(k));
}
#else
APART v exponential(v a) {
    v r;
    EACH_LANE LANE(r) = OF_REAL(exp)(LANE(a));
    return r;
}
#endif

#define BY_LANES(name, function) \
    APART v name(v a) { \
        v r; \
        EACH_LANE LANE(r) = OF_REAL(function)(LANE(a)); \
        return r; \
    }
#define BY_LANES_2(name, function) \
    APART v name(v a, v b) { \
        v r; \
        EACH_LANE LANE(r) = OF_REAL(function)(LANE(a), LANE(b)); \
        return r; \
    }
BY_LANES(tangent, tan)
BY_LANES(arc_sine, asin)
BY_LANES(arc_cosine, acos)
BY_LANES(arc_tangent, atan)
BY_LANES(logarithm, log)
BY_LANES(hyperbolic_tangent, tanh)
BY_LANES(hyperbolic_sine, sinh)
BY_LANES(hyperbolic_cosine, cosh)
BY_LANES(inverse_hyperbolic_sine, asinh)
BY_LANES(inverse_hyperbolic_cosine, acosh)
BY_LANES(inverse_hyperbolic_tangent, atanh)
BY_LANES(rounded_down, floor)
BY_LANES(rounded_up, ceil)
BY_LANES_2(arc_tangent_2, atan2)
BY_LANES_2(raised, pow)
BY_LANES_2(what_is_left, fmod)
INLINE v remainder_of(v a, v b) { /* with the sign of the divisor */
    const v zero = splat(R(0.0)), r = what_is_left(a, b), other = r + b;
    return select(r < zero, select(zero < b, other, r), select(zero < r, select(b < zero, other, r), r));
}
