// A pack: one number of each of `kWidth` simulations that run side by side in vector registers.
//
// Each kernels_*.cpp defines IFA_LANES_NAMESPACE and IFA_LANES_WIDTH and is compiled for its own instruction
// set. Everything in lanes/ lives in that namespace, and uses neither Eigen nor inline functions of the
// standard library: those would be compiled for the set too, and the linker might keep that copy for all.
//
// Every width gives the same bits: only IEEE operations lane by lane (+, -, *, /, sqrt, comparisons), no
// fused multiply-add, no sum across lanes, and a lane that is done is left alone while others go on.
#pragma once

#if IFA_LANES_WIDTH > 1
#include <immintrin.h>
#endif

namespace ifa::IFA_LANES_NAMESPACE {

inline constexpr int kWidth = IFA_LANES_WIDTH;

#if IFA_LANES_WIDTH == 1

using Pack = double;
using Mask = bool;

inline Pack broadcast(double x) { return x; }
inline double get(Pack p, int) { return p; }
inline void set(Pack& p, int, double x) { p = x; }
inline void set(Mask& m, int, bool on) { m = on; }
inline unsigned bits(Mask m) { return m ? 1u : 0u; }
inline Pack select(Mask m, Pack yes, Pack no) { return m ? yes : no; }
inline Pack root(Pack p) { return __builtin_sqrt(p); }
inline Pack least(Pack a, Pack b) { return a < b ? a : b; }
inline Pack greatest(Pack a, Pack b) { return a > b ? a : b; }
inline Pack magnitude(Pack p) { return __builtin_fabs(p); }
inline Mask mask_of(bool on) { return on; }
inline Mask negated(Mask m) { return !m; }

#else

#if IFA_LANES_WIDTH == 2
#define IFA_LANES_OP(name) _mm_##name##_pd
#define IFA_LANES_COMPARE(name, predicate) _mm_cmp##name##_pd(a.v, b.v)
using Register = __m128d;
using Bits = __m128d;
#elif IFA_LANES_WIDTH == 4
#define IFA_LANES_OP(name) _mm256_##name##_pd
#define IFA_LANES_COMPARE(name, predicate) _mm256_cmp_pd(a.v, b.v, predicate)
using Register = __m256d;
using Bits = __m256d;
#else
#define IFA_LANES_OP(name) _mm512_##name##_pd
#define IFA_LANES_COMPARE(name, predicate) _mm512_cmp_pd_mask(a.v, b.v, predicate)
using Register = __m512d;
using Bits = __mmask8;
#endif

struct Pack {
  Register v;

  Pack() = default;
  Pack(Register r) : v(r) {}
  Pack(double x) : v(IFA_LANES_OP(set1)(x)) {}  // the same for all
};
struct Mask {
  Bits v;
};

inline Pack operator+(Pack a, Pack b) { return IFA_LANES_OP(add)(a.v, b.v); }
inline Pack operator-(Pack a, Pack b) { return IFA_LANES_OP(sub)(a.v, b.v); }
inline Pack operator*(Pack a, Pack b) { return IFA_LANES_OP(mul)(a.v, b.v); }
inline Pack operator/(Pack a, Pack b) { return IFA_LANES_OP(div)(a.v, b.v); }
inline Pack operator-(Pack a) { return IFA_LANES_OP(xor)(a.v, IFA_LANES_OP(set1)(-0.0)); }
inline Pack& operator+=(Pack& a, Pack b) { return a = a + b; }
inline Mask operator<(Pack a, Pack b) { return {IFA_LANES_COMPARE(lt, _CMP_LT_OQ)}; }
inline Mask operator<=(Pack a, Pack b) { return {IFA_LANES_COMPARE(le, _CMP_LE_OQ)}; }
inline Mask operator>(Pack a, Pack b) { return b < a; }
inline Mask operator>=(Pack a, Pack b) { return b <= a; }
inline Mask operator==(Pack a, Pack b) { return {IFA_LANES_COMPARE(eq, _CMP_EQ_OQ)}; }
inline Mask operator!=(Pack a, Pack b) { return {IFA_LANES_COMPARE(neq, _CMP_NEQ_UQ)}; }
inline Pack broadcast(double x) { return x; }
inline double get(Pack p, int lane) { return p.v[lane]; }
inline void set(Pack& p, int lane, double x) { p.v[lane] = x; }
inline Pack magnitude(Pack p) { return IFA_LANES_OP(andnot)(IFA_LANES_OP(set1)(-0.0), p.v); }
// Where neither is less, b: as the scalar expressions have it.
#if IFA_LANES_WIDTH == 8
inline unsigned bits(Mask m) { return m.v; }
inline Mask mask_of_bits(unsigned b) { return {static_cast<__mmask8>(b)}; }
inline Mask operator&(Mask a, Mask b) { return {static_cast<__mmask8>(a.v & b.v)}; }
inline Mask operator|(Mask a, Mask b) { return {static_cast<__mmask8>(a.v | b.v)}; }
inline Mask negated(Mask m) { return {static_cast<__mmask8>(~m.v)}; }
inline Pack select(Mask m, Pack yes, Pack no) { return _mm512_mask_blend_pd(m.v, no.v, yes.v); }
// The masked forms: those without leave a register undefined that some compilers then warn of.
inline Pack root(Pack p) { return _mm512_maskz_sqrt_pd(0xff, p.v); }
inline Pack least(Pack a, Pack b) { return _mm512_maskz_min_pd(0xff, a.v, b.v); }
inline Pack greatest(Pack a, Pack b) { return _mm512_maskz_max_pd(0xff, a.v, b.v); }
#else
inline unsigned bits(Mask m) { return static_cast<unsigned>(IFA_LANES_OP(movemask)(m.v)); }
inline Mask operator&(Mask a, Mask b) { return {IFA_LANES_OP(and)(a.v, b.v)}; }
inline Mask operator|(Mask a, Mask b) { return {IFA_LANES_OP(or)(a.v, b.v)}; }
inline Pack root(Pack p) { return IFA_LANES_OP(sqrt)(p.v); }
inline Pack least(Pack a, Pack b) { return IFA_LANES_OP(min)(a.v, b.v); }
inline Pack greatest(Pack a, Pack b) { return IFA_LANES_OP(max)(a.v, b.v); }
#if IFA_LANES_WIDTH == 4
inline Mask mask_of_bits(unsigned b) {
  const auto lane = [b](int l) { return -static_cast<long long>(b >> l & 1u); };
  return {_mm256_castsi256_pd(_mm256_setr_epi64x(lane(0), lane(1), lane(2), lane(3)))};
}
inline Pack select(Mask m, Pack yes, Pack no) { return _mm256_blendv_pd(no.v, yes.v, m.v); }
#else
inline Mask mask_of_bits(unsigned b) {
  const auto lane = [b](int l) { return -static_cast<long long>(b >> l & 1u); };
  return {_mm_castsi128_pd(_mm_set_epi64x(lane(1), lane(0)))};
}
inline Pack select(Mask m, Pack yes, Pack no) {  // SSE2 has no blend
  return _mm_or_pd(_mm_and_pd(m.v, yes.v), _mm_andnot_pd(m.v, no.v));
}
#endif
inline Mask negated(Mask m) { return {IFA_LANES_OP(xor)(m.v, mask_of_bits(~0u).v)}; }
#endif
inline Mask mask_of(bool on) { return mask_of_bits(on ? ~0u : 0u); }
inline void set(Mask& m, int lane, bool on) {
  m = mask_of_bits((bits(m) & ~(1u << lane)) | (on ? 1u << lane : 0u));
}

#endif

inline bool any(Mask m) { return bits(m) != 0; }
inline bool get_bit(Mask m, int lane) { return (bits(m) >> lane & 1u) != 0; }
inline Mask none() { return mask_of(false); }
inline Pack clamp(Pack p, Pack low, Pack high) { return least(greatest(p, low), high); }
inline Pack positive(Pack p) { return greatest(p, broadcast(0.0)); }

struct Pack3 {
  Pack x, y, z;
};
struct Quaternion {
  Pack w, x, y, z;
};

inline Pack3 broadcast(double x, double y, double z) { return {broadcast(x), broadcast(y), broadcast(z)}; }
inline Pack3 broadcast(const double* p) { return broadcast(p[0], p[1], p[2]); }
inline Pack3 operator+(const Pack3& a, const Pack3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Pack3 operator-(const Pack3& a, const Pack3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Pack3 operator*(Pack s, const Pack3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Pack dot(const Pack3& a, const Pack3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Pack norm(const Pack3& a) { return root(dot(a, a)); }
inline Pack3 cross(const Pack3& a, const Pack3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Pack3 select(Mask m, const Pack3& a, const Pack3& b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}
inline Quaternion select(Mask m, const Quaternion& a, const Quaternion& b) {
  return {select(m, a.w, b.w), select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}
inline Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z, a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x};
}
inline Quaternion normalized(const Quaternion& q) {
  const Pack s = broadcast(1.0) / root(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {s * q.w, s * q.x, s * q.y, s * q.z};
}

// The columns of a rotation matrix: the images of the axes. Its rows: where world axes are seen from inside.
struct Rotation {
  Pack3 x, y, z;  // columns

  Pack3 apply(const Pack3& v) const { return v.x * x + v.y * y + v.z * z; }
  Pack3 inverse(const Pack3& v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }
  Pack3 up() const { return {x.z, y.z, z.z}; }  // the ground's normal in the inner axes
};

inline Rotation rotation(const Quaternion& q) {
  const Pack two = broadcast(2.0), one = broadcast(1.0);
  const Pack xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const Pack wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{one - two * (yy + zz), two * (xy + wz), two * (xz - wy)},
          {two * (xy - wz), one - two * (xx + zz), two * (yz + wx)},
          {two * (xz + wy), two * (yz - wx), one - two * (xx + yy)}};
}

struct SinCos {
  Pack sine, cosine;
};

// To a few units in the last place for |x| < 1e5, by reduction to an eighth of a turn (Cody and Waite, three
// parts of pi / 2) and Taylor's polynomials, whose first omitted terms are below 1e-17 there.
inline SinCos sin_cos(Pack x) {
  const Pack magic = broadcast(6755399441055744.0);  // 1.5 * 2^52: adding it rounds to a whole number
  const Pack turns = (x * 0.63661977236758134308 + magic) - magic;
  const Pack r = ((x - turns * 1.57079632673412561417) - turns * 6.07710050630396597660e-11) -
                 turns * 2.02226624879595063154e-21;
  const Pack r2 = r * r;
  Pack s = broadcast(1.0 / 355687428096000.0);
  s = s * r2 - 1.0 / 1307674368000.0;
  s = s * r2 + 1.0 / 6227020800.0;
  s = s * r2 - 1.0 / 39916800.0;
  s = s * r2 + 1.0 / 362880.0;
  s = s * r2 - 1.0 / 5040.0;
  s = s * r2 + 1.0 / 120.0;
  s = s * r2 - 1.0 / 6.0;
  s = r + r * r2 * s;
  Pack c = broadcast(1.0 / 20922789888000.0);
  c = c * r2 - 1.0 / 87178291200.0;
  c = c * r2 + 1.0 / 479001600.0;
  c = c * r2 - 1.0 / 3628800.0;
  c = c * r2 + 1.0 / 40320.0;
  c = c * r2 - 1.0 / 720.0;
  c = c * r2 + 1.0 / 24.0;
  c = (broadcast(1.0) - 0.5 * r2) + r2 * r2 * c;
  const Pack quarter = turns - 4.0 * ((turns * 0.25 + magic) - magic);  // -2 .. 2
  const Mask odd = magnitude(quarter) == broadcast(1.0);
  const Mask half = magnitude(quarter) == broadcast(2.0);
  const Pack sine = select(odd, c, s), cosine = select(odd, s, c);
  const Mask flip_sine = half | (quarter == broadcast(-1.0));
  const Mask flip_cosine = half | (quarter == broadcast(1.0));
  return {select(flip_sine, -sine, sine), select(flip_cosine, -cosine, cosine)};
}

// The unit quaternion of a rotation vector of moderate length.
inline Quaternion rotation_exp(const Pack3& theta) {
  const Pack angle = norm(theta);
  const SinCos half = sin_cos(0.5 * angle);
  // sin(a / 2) / a by its series where the division would lose digits
  const Pack s = select(angle > broadcast(1e-4), half.sine / angle, 0.5 - angle * angle * (1.0 / 48.0));
  return {half.cosine, s * theta.x, s * theta.y, s * theta.z};
}

}  // namespace ifa::IFA_LANES_NAMESPACE
