#pragma once

#include <array>
#include <cstddef>
#include <string_view>

/// What a module's list of coefficients is written with: it calls visit(name, log_sd, reference, scale) for each
/// coefficient, or group of them, that is known up to a factor, always in the same order; scale(k) multiplies it by k.
/// The log_sd are those of docs/gap-locate.md for a model with empirical or regressed coefficients. Names begin with
/// the module's group. The reference says what a coefficient is in the literature: the module's own, or another where
/// the module's source does not have it.
namespace leeway {

template <typename M>
concept HasReference = !std::string_view(M::reference).empty();

template <typename T>
auto factor_on(T& coefficient) {
  return [&coefficient](const T& k) { coefficient *= k; };
}

/// On all of them.
template <typename T, std::size_t n>
auto factor_on(std::array<T, n>& coefficients) {
  return [&coefficients](const T& k) {
    for (T& coefficient : coefficients) coefficient *= k;
  };
}

/// On 1 - x, for a wake fraction or a thrust deduction x.
template <typename T>
auto factor_on_rest(T& x) {
  return [&x](const T& k) { x = 1.0 - k * (1.0 - x); };
}

}  // namespace leeway
