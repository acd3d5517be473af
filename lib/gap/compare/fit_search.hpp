#pragma once

#include <optional>
#include <vector>

#include "gap/compare/fitted.hpp"

namespace leeway::gap {

/// Whether a fit may begin from coefficients as stated: those of `from` have moved, and what is added is nothing at no
/// finite strength, as little water under the keel.
bool may_begin_as_stated(const Fitted& from, const Start& added);

/// Looks for the likeliest fit of a hypothesis, which may have several optima: from several starts, from coefficients
/// as stated, with less model error.
class FitSearch {
 public:
  FitSearch(const Campaign& campaign, const FitOptions& options);

  /// The likeliest fit of what is added to `from`; nothing where the simulator runs away with it.
  ///   most_starts  from which it is fitted, the one of the largest expected gain first
  std::optional<Fitted> fit(const Fitted& from, const std::vector<Start>& starts, std::size_t most_starts) const;
  /// Continues a fit as long as it gains, also from other noise levels; whether it gained.
  bool continue_fit(Fitted& fitted) const;
  /// Fits again from coefficients as stated, which are no more uncertain than that; whether it gained.
  bool fit_as_stated(Fitted& fitted) const;
  /// Fits again at the likeliest common scale of the coefficients.
  void choose_scale(Fitted& fitted) const;
  /// Nothing missing, fitted from the noise, events and coefficients of another fit of the same campaign; nothing where
  /// that is no better optimum.
  std::optional<Fitted> better_none(Fitted none, const Fitted& other) const;

 private:
  std::optional<FittedNull> refit(const FittedNull& from, const Hypothesis& hypothesis,
                                  const Eigen::VectorXd& theta) const;
  std::optional<Fitted> fitted_from(const Fitted& from, const Start& start) const;
  std::optional<Fitted> likeliest(const Fitted& from, const std::vector<Start>& starts, std::size_t most_starts) const;
  void climb(Fitted& fitted, double model_error) const;

  const Campaign& campaign_;
  FitOptions options_;
};

}  // namespace leeway::gap
