#pragma once

#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "forces/coefficient_list.hpp"
#include "forces/source.hpp"
#include "io/json.hpp"

namespace leeway {

/// The force modules that a ship may have in one place. A module M<T> has a name, M::Coefficients that read themselves
/// from JSON, a constructor that takes these and what else its place gives, a force, and a list of coefficients, each
/// with its reference: the module's own unless it has another.
template <template <typename> typename... Module>
struct ModuleList {
  static_assert((HasReference<Module<double>> && ...), "a module does not say what its coefficients are");
  template <typename T>
  using Of = std::variant<Module<T>...>;
  using Coefficients = std::variant<typename Module<double>::Coefficients...>;

  /// Reads a module's JSON object by its "type". Throws InputError for whatever is wrong with it.
  static Coefficients read(const io::JsonObject& json) {
    const std::string type = json.word("type", {std::string(Module<double>::name)...});
    require_source(json);
    std::optional<Coefficients> result;
    ((type == Module<double>::name && (result = Module<double>::Coefficients::read(json))), ...);
    json.check_all_known();
    return *std::move(result);
  }

  /// The module with these coefficients.
  template <typename T, typename... Place>
  static Of<T> make(const Coefficients& coefficients, const Place&... place) {
    std::optional<Of<T>> result;
    const auto make_if = [&]<typename M>(std::type_identity<M>) {
      if (const auto* c = std::get_if<typename M::Coefficients>(&coefficients))
        result.emplace(std::in_place_type<M>, *c, place...);
    };
    (make_if(std::type_identity<Module<T>>()), ...);
    return *std::move(result);
  }

  /// Whether the module with these coefficients is what `asked`, a lambda, says of its type.
  template <typename Asked>
  static bool is(const Coefficients& coefficients, const Asked& asked) {
    return ((std::holds_alternative<typename Module<double>::Coefficients>(coefficients) &&
             asked.template operator()<Module<double>>()) ||
            ...);
  }
};

}  // namespace leeway
