#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>

/// What a module's list of coefficients is written with: it calls visit(name, log_sd, reference, scale) for each
/// coefficient, or group of them, that is known up to a factor, always in the same order; scale(k) multiplies it by k.
/// Where the coefficient is a single number, the scale moves it by a difference as well and tells its value.
/// The log_sd are those of docs/gap-locate.md for a model with empirical or regressed coefficients. Names begin with
/// the module's group. The reference says what a coefficient is in the literature: the module's own, or another where
/// the module's source does not have it.
namespace leeway {

template <typename M>
concept HasReference = !std::string_view(M::reference).empty();

/// One number: multiplied, moved by a difference in its own unit, and read.
template <typename T>
struct FactorOn {
  T& coefficient;
  void operator()(const T& k) const { coefficient *= k; }
  void move(const T& difference) const { coefficient += difference; }
  const T& value() const { return coefficient; }
};

/// 1 - x, for a wake fraction or a thrust deduction x: its sign is certain, so that it is multiplied alone.
template <typename T>
struct FactorOnRest {
  T& x;
  void operator()(const T& k) const { x = 1.0 - k * (1.0 - x); }
  T value() const { return 1.0 - x; }
};

/// What a scale of a list of coefficients may offer besides multiplying.
template <typename S>
concept TellsValue = requires(const S& scale) {
  scale.value();
};
template <typename S, typename T>
concept MovesBy = requires(const S& scale, const T& difference) {
  scale.move(difference);
};

template <typename T>
FactorOn<T> factor_on(T& coefficient) {
  return {coefficient};
}

/// A term of another form of the same force, as the literature has it beside the module's own: 0 as it is shipped, and
/// nothing of a ship's file. A factor k adds ln k to it. It is as uncertain as published forms differ, and never by far
/// more.
template <typename T>
struct FormTerm {
  T& term;
  bool& is_own;  ///< whether all terms of the module are 0
  void operator()(const T& k) const {
    using std::log;
    term += log(k);
    is_own = false;
  }
};
template <typename S>
inline constexpr bool kIsFormTerm = false;
template <typename T>
inline constexpr bool kIsFormTerm<FormTerm<T>> = true;

/// On all of them.
template <typename T, std::size_t n>
auto factor_on(std::array<T, n>& coefficients) {
  return [&coefficients](const T& k) {
    for (T& coefficient : coefficients) coefficient *= k;
  };
}

template <typename T>
FactorOnRest<T> factor_on_rest(T& x) {
  return {x};
}

}  // namespace leeway
