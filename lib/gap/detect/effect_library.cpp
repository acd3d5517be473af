#include "gap/detect/effect_library.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/statistics.hpp"
#include "gap/detect/helm.hpp"
#include "gap/filter/reference_units.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// A strength that is worth finding: one prior sd from nothing.
double nominal(const EffectParameter& parameter, const Prior& prior) {
  if (std::isnan(parameter.off)) return prior.median;
  switch (prior.kind) {
    case Prior::Kind::normal:
      return parameter.off + prior.sd;
    case Prior::Kind::rayleigh:
      return prior.sd;
    case Prior::Kind::log_normal:
      return parameter.off > 0.0 ? parameter.off * std::exp(-std::min(prior.sd, kPolicy.detect.most_log_strength))
                                 : prior.median;
    case Prior::Kind::uniform:
      return parameter.off + kPolicy.detect.uniform_share * (prior.high - parameter.off);
  }
  return prior.median;
}

// The parameter values of an effect's variants: each strength for itself, in each direction. A vector whose
// direction has a default (the current in a shear) keeps its default: it is an effect of its own.
std::vector<std::vector<double>> variants_of(std::span<const EffectParameter> parameters, double L_pp) {
  const auto prior = [&](const EffectParameter& p) { return p.prior(L_pp); };
  std::vector<std::size_t> strengths;
  std::optional<std::size_t> direction;
  std::vector<double> base;
  const bool keeps_vector = std::any_of(parameters.begin(), parameters.end(), [&](const EffectParameter& p) {
    return is_direction(prior(p)) && !std::isnan(p.otherwise);
  });
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const EffectParameter& p = parameters[i];
    base.push_back(std::isfinite(p.otherwise) ? p.otherwise : std::isfinite(p.off) ? p.off : prior(p).median);
    if (keeps_vector && (is_direction(prior(p)) || prior(p).kind == Prior::Kind::rayleigh)) continue;
    if (is_direction(prior(p)))
      direction = i;
    else if (std::isfinite(p.off) || (std::isnan(p.off) && std::isnan(p.otherwise)))
      strengths.push_back(i);
  }
  std::vector<std::vector<double>> variants;
  for (const std::size_t i : strengths) {
    std::vector<double> values = base;
    values[i] = nominal(parameters[i], prior(parameters[i]));
    for (const double angle_deg : {0.0, 90.0, 180.0, 270.0}) {
      if (direction) values[*direction] = angle_deg;
      variants.push_back(values);
      if (!direction) break;
    }
  }
  return variants;
}

// Names of the effects that an ensemble has in these forms.
std::string names_of(std::initializer_list<EnsembleForm> forms) {
  std::vector<std::string_view> names;
  for (const EnsembleForm form : forms)
    for (const EffectDescription& effect : effect_catalogue())
      if (effect.info.to_ensemble == form) names.push_back(effect.info.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

double angle_change(const Stretch& stretch, const RecordedInputs& one, const RecordedInputs& other) {
  const double from_s = stretch.t_s.front(), duration_s = stretch.t_s.back() - from_s;
  const auto n =
      static_cast<int>(kPolicy.detect.angles_per_sample * duration_s / std::min(stretch.sample_s, stretch.dt_s(0)));
  double squares = 0.0, count = 0.0;
  for (int i = 0; i < n; ++i) {
    const double t = from_s + duration_s * i / n;
    const Actuators<double> a = one.at(t).actuators, b = other.at(t).actuators;
    for (const Channel channel : one.channels())
      if (info(channel).role == Role::rudder) {
        squares += std::pow(b[channel] - a[channel], 2);
        count += 1.0;
      }
  }
  return count > 0.0 ? squares / count : 0.0;
}

Identifiable::Identifiable(const Campaign& campaign, const FittedNull& fit) : keeps_course_(!campaign.ensemble) {
  const auto width = [](std::vector<double> values) {
    std::erase_if(values, [](double value) { return std::isnan(value); });
    if (values.empty()) return std::numeric_limits<double>::infinity();
    std::sort(values.begin(), values.end());
    return quantile(values, 1.0 - kPolicy.detect.tail_share) - quantile(values, kPolicy.detect.tail_share);
  };
  for (std::size_t s = 0; s < campaign.stretches.size() && keeps_course_; ++s) {
    const Stretch& stretch = campaign.stretches[s];
    keeps_course_ = stretch.helm || is_straight(campaign, stretch, fit.smoothed[s]);
    for (const Actuator& actuator : campaign.ship.actuators) {
      if (info(actuator.channel).role != Role::thruster) continue;
      std::vector<double> values;
      for (const std::vector<StepInputs<double>>& step : stretch.inputs)
        values.push_back(step.front().start.actuators[actuator.channel]);
      keeps_course_ = keeps_course_ && width(values) < kPolicy.detect.kept_actuator_share * actuator.range();
    }
  }
}

bool Identifiable::operator()(std::string_view effect) const {
  return !keeps_course_ || !effect_named(effect).info.needs_turns;
}

EffectLibrary::EffectLibrary(const Campaign& campaign, const FittedNull& fit)
    : campaign_(campaign), fit_(fit), variants_(campaign.recordings.size()) {
  if (campaign.ensemble) {
    add_derived();
    return;
  }
  std::vector<Ship> ships;
  for (std::size_t r = 0; r < campaign.recordings.size(); ++r) {
    ships.push_back(campaign.ship_in(r));
    apply_uncertainty(null_.emplace_back(ships.back()), fit.theta);
  }
  const std::vector<EffectDescription>& catalogue = effect_catalogue();
  const Identifiable is_identifiable(campaign, fit);
  for (std::size_t type = 0; type < catalogue.size(); ++type) {
    const std::string name(catalogue[type].info.name);
    if (!is_screened(catalogue[type].info.search)) continue;
    if (!is_identifiable(name)) {
      not_applicable_.push_back(name + ": the ship keeps its course");
      continue;
    }
    Entry entry{name, columns(), 0};
    std::string problem;
    for (const std::vector<double>& values : variants_of(catalogue[type].parameters, campaign.ship.particulars.L_pp)) {
      try {
        require_applicable(type, values, campaign.ship);
        for (std::size_t r = 0; r < ships.size(); ++r) {
          Model<double> model(ships[r], type, values);
          apply_uncertainty(model, fit.theta);
          variants_[r].push_back({std::move(model)});
        }
        ++entry.count;
      } catch (const EffectNotApplicable& reason) {  // some strengths may apply: k_R to a single rudder, k_P not
        problem = reason.what();
      }
    }
    const RudderResponse own = null_.front().rudder_response();
    if (const RudderResponse with = entry.count > 0 ? variants_.front().back().response() : own; with != own) {
      double most = 0.0;
      for (const Stretch& stretch : campaign.stretches) {
        const RecordedInputs& recorded = campaign.recorded_inputs[stretch.recording];
        most = std::max(most, angle_change(stretch, recorded.through(own), recorded.through(with)));
      }
      if (most < kKnownAngle * kKnownAngle) {
        for (std::vector<Variant>& variants : variants_)
          for (Eigen::Index i = 0; i < entry.count; ++i) variants.pop_back();
        entry.count = 0;
        problem = "the rudders hardly move";
      }
    }
    if (entry.count == 0) {
      not_applicable_.push_back(fmt::format("{}: {}", name, problem));
      continue;
    }
    const EffectParameter& first = catalogue[type].parameters.front();
    entry.is_one_sided = entry.count == 1 && (std::isnan(first.off) || first.low >= first.off);
    entries_.push_back(entry);
  }
}

void EffectLibrary::add_derived() {
  //   make  columns for the nominal value of its first parameter
  const auto add = [&](EnsembleForm form, const std::function<std::vector<Derived>(double strength)>& make) {
    for (const EffectDescription& effect : effect_catalogue()) {
      if (effect.info.to_ensemble != form) continue;
      const EffectParameter& first = effect.parameters.front();
      const std::vector<Derived> columns = make(nominal(first, first.prior(campaign_.ship.particulars.L_pp)));
      entries_.push_back({std::string(effect.info.name), static_cast<Eigen::Index>(derived_.size()),
                          static_cast<Eigen::Index>(columns.size())});
      derived_.insert(derived_.end(), columns.begin(), columns.end());
    }
  };
  // What an acceleration over the step does.
  const auto push = [](const LinearStretch& stretch, std::size_t k, const Vec3<double>& acceleration) -> Vec6 {
    return stretch.steps[k].A.middleCols<3>(kErrorStart) * acceleration;
  };
  std::vector<Derived> body;
  body.reserve(3);
  for (int axis = 0; axis < 3; ++axis)
    body.emplace_back(
        [push, size = Vec3<double>(kPolicy.detect.reference_acceleration_mps2 * Vec3<double>::Unit(axis))](
            const LinearStretch& stretch, std::size_t k) { return push(stretch, k, size); });
  // Yaw by what the acceleration is at a quarter of the length from midship.
  body.back() = [push, r = reference_acceleration(campaign_.ship)[2]](const LinearStretch& stretch, std::size_t k) {
    return push(stretch, k, {0.0, 0.0, r});
  };
  using enum EnsembleForm;
  add(body_acceleration, [&](double) { return body; });
  if (!campaign_.has_heading) {
    not_applicable_.push_back(names_of({earth_acceleration, water_velocity, wind_velocity}) +
                              ": no heading is recorded");
    return;
  }
  const auto to_north_and_east = [](const std::function<Derived(const Vec2<double>& along)>& column) {
    return std::vector<Derived>{column({1.0, 0.0}), column({0.0, 1.0})};
  };
  const auto in_ship_axes = [](const Vec2<double>& along, double psi) -> Vec3<double> {
    const double c = std::cos(psi), s = std::sin(psi);
    return {c * along(0) + s * along(1), -s * along(0) + c * along(1), 0.0};
  };
  add(earth_acceleration, [&](double) {
    return to_north_and_east([&](const Vec2<double>& along) -> Derived {
      return [along, push, in_ship_axes](const LinearStretch& stretch, std::size_t k) {
        return push(stretch, k, kPolicy.detect.reference_acceleration_mps2 * in_ship_axes(along, stretch.path[k][2]));
      };
    });
  });
  // The step is taken with the velocity through the water; the wind over the ground is what it was.
  add(water_velocity, [&](double speed) {
    return to_north_and_east([&](const Vec2<double>& along) -> Derived {
      return [along, in_ship_axes, speed](const LinearStretch& stretch, std::size_t k) -> Vec6 {
        const auto& A = stretch.steps[k].A;
        Vec6 column =
            A.middleCols<2>(kWindStart) * along - A.middleCols<3>(3) * in_ship_axes(along, stretch.path[k][2]);
        column.head<2>() += stretch.data->dt_s(k) * along;
        column.tail<3>() += in_ship_axes(along, stretch.path[k + 1][2]);
        return speed * column;
      };
    });
  });
  if (campaign_.ship.has_wind())
    add(wind_velocity, [&](double speed) {
      return to_north_and_east([&](const Vec2<double>& along) -> Derived {
        return [along, speed](const LinearStretch& stretch, std::size_t k) -> Vec6 {
          return speed * stretch.steps[k].A.middleCols<2>(kWindStart) * along;
        };
      });
    });
  else
    not_applicable_.push_back(names_of({wind_velocity}) + ": the ensemble does not see the wind");
  not_applicable_.emplace_back("all effects that change forces: the ensemble has none; gap-explain --ship tries them");
}

MoreColumns EffectLibrary::columns_of(std::size_t stretch_index, std::vector<std::size_t> entries) const {
  const LinearStretch& stretch = fit_.stretches[stretch_index];
  if (campaign_.ensemble)
    return [this, &stretch, entries = std::move(entries)](std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) {
      Eigen::Index column = 0;
      for (const std::size_t e : entries)
        for (Eigen::Index i = 0; i < entries_[e].count; ++i)
          out.col(column++) = derived_[static_cast<std::size_t>(entries_[e].first + i)](stretch, k);
    };
  const std::size_t recording = stretch.data->recording;
  const Model<double>& null = null_[recording];
  const std::vector<Variant>& variants = variants_[recording];
  // Of those whose rudders act otherwise.
  std::map<Eigen::Index, RecordedInputs> inputs_of;
  for (const std::size_t e : entries)
    for (Eigen::Index i = entries_[e].first; i < entries_[e].first + entries_[e].count; ++i)
      if (const RudderResponse& response = variants[static_cast<std::size_t>(i)].response();
          response != null.rudder_response())
        inputs_of.emplace(i, campaign_.recorded_inputs[recording].through(response));
  return [this, &stretch, &null, &variants, inputs_of = std::move(inputs_of), entries = std::move(entries)](
             std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) {
    const StateVector& x = stretch.path[k];
    const std::vector<StepInputs<double>>& inputs = stretch.data->inputs[k];
    const double h = stretch.data->dt_s(k) / static_cast<double>(inputs.size());
    const Vec6 without = advance<double>(null, x, inputs, h);
    Eigen::Index column = 0;
    for (const std::size_t e : entries)
      for (Eigen::Index i = 0; i < entries_[e].count; ++i, ++column) {
        const Variant& variant = variants[static_cast<std::size_t>(entries_[e].first + i)];
        if (const auto slowed = inputs_of.find(entries_[e].first + i); slowed != inputs_of.end()) {
          std::vector<StepInputs<double>> slow = inputs;
          for (std::size_t s = 0; s < slow.size(); ++s)
            slow[s] = averaged_step(slowed->second, stretch.data->t_s[k] + static_cast<double>(s) * h, h);
          out.col(column) = stretch.steps[k].answered(advance<double>(variant.model, x, slow, h) - without);
        } else {
          out.col(column) = stretch.steps[k].answered(advance<double>(variant.model, x, inputs, h) - without);
        }
      }
  };
}

}  // namespace leeway::gap
