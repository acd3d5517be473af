#pragma once

#if defined(__FMA__)
#include <immintrin.h>
#endif

/// Vectors of the instruction set that a kernel is compiled for, and the functions of them that the networks need.
/// For rollout_kernel.cpp alone: everything has internal linkage, so that no other code can come to share it.
namespace leeway::nn::LEEWAY_KERNEL {
namespace {

#if defined(__AVX512F__)
constexpr int kVectorBytes = 64;
#elif defined(__AVX2__)
constexpr int kVectorBytes = 32;
#else
constexpr int kVectorBytes = 16;
#endif

template <typename S>
struct VectorTypes {};
template <>
struct VectorTypes<float> {
  typedef float Real __attribute__((vector_size(kVectorBytes), may_alias));
  typedef int Integer __attribute__((vector_size(kVectorBytes), may_alias));
};
template <>
struct VectorTypes<double> {
  typedef double Real __attribute__((vector_size(kVectorBytes), may_alias));
  typedef long long Integer __attribute__((vector_size(kVectorBytes), may_alias));
};
template <typename S>
using Vector = typename VectorTypes<S>::Real;
template <typename S>
using IntegerVector = typename VectorTypes<S>::Integer;
template <typename S>
constexpr int kWidth = kVectorBytes / static_cast<int>(sizeof(S));

template <typename S>
inline Vector<S> load(const S* from) {
  return *reinterpret_cast<const Vector<S>*>(from);
}

template <typename S>
inline void store(S* to, Vector<S> value) {
  *reinterpret_cast<Vector<S>*>(to) = value;
}

template <typename S>
inline Vector<S> broadcast(S value) {
  return value - Vector<S>{};  // the compiler may leave out the zero, which it may not in a sum
}

/// a*b + c, with one rounding where the instruction set has it. Asked for by name: the compiler contracts nothing.
template <typename S>
inline Vector<S> multiply_add(Vector<S> a, Vector<S> b, Vector<S> c) {
  return a * b + c;
}
#if defined(__AVX512F__)
template <>
inline Vector<float> multiply_add<float>(Vector<float> a, Vector<float> b, Vector<float> c) {
  return _mm512_fmadd_ps(a, b, c);
}
#elif defined(__AVX2__)
template <>
inline Vector<float> multiply_add<float>(Vector<float> a, Vector<float> b, Vector<float> c) {
  return _mm256_fmadd_ps(a, b, c);
}
#endif

/// Calls a function of scalars for each element; the compiler's builtins, because <cmath> is shared code.
template <typename Function>
inline Vector<double> each(Vector<double> x, const Function& function) {
  for (int i = 0; i < kWidth<double>; ++i) x[i] = function(x[i]);
  return x;
}

/// tanh to 2.5 units in the last place; 1 beyond 9.01, and no number remains none.
///   tanh x = e / (e + 2) with e = exp(2x) - 1 = 2^n (exp(y) - 1) + (2^n - 1), 2x = n ln 2 + y, |y| <= ln(2) / 2
/// Keeps its relative accuracy towards zero, where n = 0 and y = 2x.
inline Vector<float> tanh(Vector<float> x) {
  using V = Vector<float>;
  using I = IntegerVector<float>;
  const I sign = reinterpret_cast<I>(x) & static_cast<int>(0x80000000U);
  V twice = reinterpret_cast<V>(reinterpret_cast<I>(x + x) & 0x7fffffff);
  const V limit = broadcast(18.2F);
  twice = limit < twice ? limit : twice;
  // Adding 1.5 * 2^23 + 127 rounds to an integer and leaves n + 127, the exponent of 2^n, in the lowest bits.
  const V magic = broadcast(12583039.0F);
  const V rounded = multiply_add<float>(twice, broadcast(1.442695041F), magic);
  const V n = rounded - magic;
  const V power = reinterpret_cast<V>(reinterpret_cast<I>(rounded) << 23);
  const V y = multiply_add<float>(n, broadcast(-0.6931471806F), twice);
  // exp(y) - 1 - y over y^2: minimax to 1.3e-8 of exp(y) - 1.
  V p = multiply_add<float>(y, broadcast(0.0013882511F), broadcast(0.0083665801F));
  p = multiply_add<float>(y, p, broadcast(0.0416672006F));
  p = multiply_add<float>(y, p, broadcast(0.1666654348F));
  p = multiply_add<float>(y, p, broadcast(0.4999999702F));
  p = multiply_add<float>(y * y, p, y);
  const V e = multiply_add<float>(power, p, power - 1.0F);
  return reinterpret_cast<V>(reinterpret_cast<I>(e / (e + 2.0F)) | sign);
}

inline Vector<double> tanh(Vector<double> x) {
  return each(x, [](double v) { return __builtin_tanh(v); });
}

/// Sine and cosine to 2e-7 for angles up to some thousand turns (a heading that is not wrapped).
inline void sine_cosine(Vector<float> x, Vector<float>& sine, Vector<float>& cosine) {
  using V = Vector<float>;
  using I = IntegerVector<float>;
  const V magic = broadcast(12582912.0F);  // 1.5 * 2^23: the quadrant is in the lowest bits
  const V rounded = multiply_add<float>(x, broadcast(0.6366197724F), magic);
  const V n = rounded - magic;
  const I quadrant = reinterpret_cast<I>(rounded);
  // pi/2 in three parts; products with the first one are exact for n up to 2^13.
  V y = multiply_add<float>(n, broadcast(-1.5703125F), x);
  y = multiply_add<float>(n, broadcast(-4.837512969970703125e-4F), y);
  y = multiply_add<float>(n, broadcast(-7.54978995489188216e-8F), y);
  const V z = y * y;
  // Taylor's series with the last terms adjusted to |y| <= pi/4 (Cephes).
  V s = multiply_add<float>(z, broadcast(-1.9515295891e-4F), broadcast(8.3321608736e-3F));
  s = multiply_add<float>(z, s, broadcast(-1.6666654611e-1F));
  s = multiply_add<float>(y * z, s, y);
  V c = multiply_add<float>(z, broadcast(2.443315711809948e-5F), broadcast(-1.388731625493765e-3F));
  c = multiply_add<float>(z, c, broadcast(4.166664568298827e-2F));
  c = multiply_add<float>(z * z, c, multiply_add<float>(z, broadcast(-0.5F), broadcast(1.0F)));
  const I odd = (quadrant & 1) != 0;
  const I negative_sine = (quadrant & 2) << 30, negative_cosine = ((quadrant + 1) & 2) << 30;
  sine = reinterpret_cast<V>(reinterpret_cast<I>(odd ? c : s) ^ negative_sine);
  cosine = reinterpret_cast<V>(reinterpret_cast<I>(odd ? s : c) ^ negative_cosine);
}

inline void sine_cosine(Vector<double> x, Vector<double>& sine, Vector<double>& cosine) {
  sine = each(x, [](double v) { return __builtin_sin(v); });
  cosine = each(x, [](double v) { return __builtin_cos(v); });
}

/// The elements of a and b at the indices, those of b from kWidth on.
template <typename S>
inline __attribute__((always_inline)) Vector<S> shuffle(Vector<S> a, Vector<S> b, IntegerVector<S> index) {
#ifdef __clang__  // which shuffles by constants alone
  Vector<S> result{};
  for (int i = 0; i < kWidth<S>; ++i) result[i] = index[i] < kWidth<S> ? a[index[i]] : b[index[i] - kWidth<S>];
  return result;
#else
  return __builtin_shuffle(a, b, index);
#endif
}

/// Exchanges elements and vectors in place: kWidth vectors are a square matrix.
template <typename S>
inline void transpose(Vector<S> (&rows)[kWidth<S>]) {
  using I = IntegerVector<S>;
  I index{};
  for (int i = 0; i < kWidth<S>; ++i) index[i] = i;
#pragma GCC unroll 8
  for (int d = kWidth<S> / 2; d > 0; d /= 2) {
    // Off-diagonal blocks of d x d change places; indices from kWidth on mean the second vector.
    const I upper = (index & d) == 0 ? index : index - d + kWidth<S>;
    const I lower = (index & d) == 0 ? index + d : index + kWidth<S>;
#pragma GCC unroll 16
    for (int i = 0; i < kWidth<S>; ++i) {
      if ((i & d) != 0) continue;
      const Vector<S> a = rows[i], b = rows[i + d];
      rows[i] = shuffle<S>(a, b, upper);
      rows[i + d] = shuffle<S>(a, b, lower);
    }
  }
}

}  // namespace
}  // namespace leeway::nn::LEEWAY_KERNEL
