#include "gap/show/next_maneuver.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include <fmt/format.h>

#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "gap/show/planned_recording.hpp"

namespace leeway::gap {
namespace {

// A maneuver and what its recordings would say.
struct Tried {
  const MenuItem* item;
  Prospect prospect;
  double p_right;

  double duration_s() const { return prospect.each_s * static_cast<double>(item->runs.size()); }
  NextManeuver told() const {
    return {item->name, fmt::format("{} --duration-s {:.0f}", item->command, prospect.each_s), duration_s(), p_right};
  }
};

class Planner {
 public:
  Planner(const Campaign& campaign, const std::vector<const Fitted*>& hypotheses,
          const std::vector<double>& probability, const NextLimits& limits, std::size_t jobs, std::uint64_t seed)
      : fitted_(hypotheses),
        probability_(probability),
        limits_(limits),
        jobs_(jobs),
        seed_(seed),
        site_(site_of(campaign, limits)),
        menu_(maneuver_menu(campaign.ship, campaign.time_scale(), limits)) {
    for (const Fitted* one : hypotheses) survivors_.push_back(survivor(*one, campaign, limits.depth_m.has_value()));
    for (Survivor& other : survivors_) other.fit.noise = survivors_.front().fit.noise;  // of one world
  }

  NextPlan plan() const {
    NextPlan result;
    result.limits = limits_;
    result.p_reachable = std::accumulate(probability_.begin(), probability_.end(), 0.0);
    const std::vector<Tried> tried = tried_in(site_);
    for (const Tried& one : tried) result.maneuvers.push_back(one.told());
    result.sequences = sequences_of(tried);
    result.records = records();
    return result;
  }

 private:
  double certainty(const Eigen::MatrixXd& apart) const { return expected_certainty(apart, probability_, seed_); }

  // The whole menu, best first.
  std::vector<Tried> tried_in(const Site& site) const {
    std::vector<std::optional<Tried>> all(menu_.size());
    parallel_for(menu_.size(), jobs_, [&](std::size_t m) {
      if (std::optional<Prospect> found = prospect(menu_[m], survivors_, site)) {
        const double p_right = certainty(squared_distances(survivors_, {&*found}));
        all[m] = Tried{&menu_[m], std::move(*found), p_right};
      }
    });
    std::vector<Tried> result;
    for (std::optional<Tried>& one : all)
      if (one) result.push_back(std::move(*one));
    std::ranges::stable_sort(result, std::greater(), &Tried::p_right);
    return result;
  }

  std::vector<NextSequence> sequences_of(const std::vector<Tried>& tried) const {
    std::vector<NextSequence> all;
    for (std::size_t i = 0; i < tried.size(); ++i)
      for (std::size_t j = i + 1; j < tried.size(); ++j)
        if (const double both_s = tried[i].duration_s() + tried[j].duration_s();
            !limits_.time_s || both_s <= *limits_.time_s)
          all.push_back({{i, j}, both_s, 0.0});
    parallel_for(all.size(), jobs_, [&](std::size_t s) {
      const auto [i, j] = all[s].maneuvers;
      all[s].p_right = certainty(squared_distances(survivors_, {&tried[i].prospect, &tried[j].prospect}));
    });
    std::erase_if(all, [&](const NextSequence& one) {
      return one.p_right <= tried[one.maneuvers[0]].p_right + kPolicy.show.worthwhile_gain;
    });
    std::ranges::stable_sort(all, std::greater(), &NextSequence::p_right);
    all.resize(std::min(all.size(), kPolicy.show.most_sequences));
    return all;
  }

  std::vector<NextRecord> records() const {
    std::vector<NextRecord> result = of_surroundings();
    for (const auto& [what, channels] : kInstruments) {
      Site site = site_;
      for (const Channel channel : channels)
        if (std::ranges::find(site.recorded, channel) == site.recorded.end()) site.recorded.push_back(channel);
      if (site.recorded.size() == site_.recorded.size()) continue;
      if (const std::vector<Tried> tried = tried_in(site); !tried.empty())
        result.push_back({std::string(what), tried.front().item->name, tried.front().p_right});
    }
    std::ranges::stable_sort(result, std::greater(), &NextRecord::p_right);
    return result;
  }

  // What acts from outside can be measured: then hypotheses with and without it are told apart in any maneuver.
  std::vector<NextRecord> of_surroundings() const {
    std::map<std::string_view, std::set<std::size_t>> having;  // hypotheses, by what would tell
    for (std::size_t h = 0; h < fitted_.size(); ++h)
      for (const FreeEffect& effect : fitted_[h]->hypothesis.effects)
        if (const std::string_view what = effect_named(effect.name()).info.to_record; !what.empty())
          having[what].insert(h);
    std::vector<NextRecord> result;
    const auto n = static_cast<Eigen::Index>(fitted_.size());
    for (const auto& [what, with] : having) {
      Eigen::MatrixXd apart = Eigen::MatrixXd::Zero(n, n);
      for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = 0; j < n; ++j)
          if (with.contains(static_cast<std::size_t>(i)) != with.contains(static_cast<std::size_t>(j)))
            apart(i, j) = kPolicy.show.apart_squared;
      if (with.size() < fitted_.size()) result.push_back({std::string(what), "", certainty(apart)});
    }
    return result;
  }

  static constexpr std::pair<std::string_view, std::array<Channel, 2>> kInstruments[] = {
      {"positions", {Channel::x0, Channel::y0}},
      {"the heading", {Channel::psi, Channel::psi}},
      {"u and v_m", {Channel::u, Channel::vm}},
      {"the yaw rate", {Channel::r, Channel::r}}};

  const std::vector<const Fitted*>& fitted_;
  const std::vector<double>& probability_;
  const NextLimits& limits_;
  const std::size_t jobs_;
  const std::uint64_t seed_;
  const Site site_;
  const std::vector<MenuItem> menu_;
  std::vector<Survivor> survivors_;
};

}  // namespace

NextPlan plan_maneuvers(const Campaign& campaign, const std::vector<const Fitted*>& hypotheses,
                        const std::vector<double>& probability, const NextLimits& limits, std::size_t jobs,
                        std::uint64_t seed) {
  return Planner(campaign, hypotheses, probability, limits, jobs, seed).plan();
}

Recommended recommended(const NextPlan& plan, double p_right, const Policy& policy) {
  const double decisive = policy.show.decisive * plan.p_reachable;
  // The shortest that decides.
  const auto shortest = [&](const auto& list) {
    std::optional<std::size_t> result;
    for (std::size_t i = 0; i < list.size(); ++i)
      if (list[i].p_right >= decisive && (!result || list[i].duration_s < list[*result].duration_s)) result = i;
    return result;
  };
  using What = Recommended::What;
  Recommended best;
  const auto offer = [&](What what, const auto& list, std::optional<std::size_t> place) {
    if (place && *place < list.size() && list[*place].p_right > best.p_right + policy.show.worthwhile_gain)
      best = {what, *place, list[*place].p_right};
  };
  best.p_right = p_right;
  offer(What::maneuver, plan.maneuvers, shortest(plan.maneuvers));
  if (best.what == What::nothing) offer(What::sequence, plan.sequences, shortest(plan.sequences));
  if (best.what != What::nothing) return best;
  offer(What::maneuver, plan.maneuvers, 0);
  offer(What::sequence, plan.sequences, 0);
  offer(What::record, plan.records, 0);
  return best;
}

double expected_certainty(const Eigen::MatrixXd& squared_distance, const std::vector<double>& probability,
                          std::uint64_t seed) {
  // Places with these distances (classical scaling, Torgerson 1952).
  const Eigen::Index n = squared_distance.rows();
  const Eigen::MatrixXd center =
      Eigen::MatrixXd::Identity(n, n) - Eigen::MatrixXd::Constant(n, n, 1.0 / static_cast<double>(n));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(-0.5 * center * squared_distance * center);
  const Eigen::MatrixXd places =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();  // one per row
  RandomStream random(seed, "next-maneuver");
  double sum = 0.0;
  for (std::size_t d = 0; d < kPolicy.show.outcome_draws; ++d) {
    Eigen::RowVectorXd noise(n);
    for (Eigen::Index i = 0; i < n; ++i) noise[i] = random.normal();
    for (Eigen::Index truth = 0; truth < n; ++truth) {
      const Eigen::RowVectorXd seen = places.row(truth) + noise;
      Eigen::VectorXd log_p(n);
      for (Eigen::Index i = 0; i < n; ++i)
        log_p[i] = std::log(std::max(probability[static_cast<std::size_t>(i)], kPolicy.show.least_probability)) -
                   0.5 * (seen - places.row(i)).squaredNorm();
      const Eigen::VectorXd p = (log_p.array() - log_p.maxCoeff()).exp();
      sum += probability[static_cast<std::size_t>(truth)] * p.maxCoeff() / p.sum();
    }
  }
  return sum / static_cast<double>(kPolicy.show.outcome_draws);
}

}  // namespace leeway::gap
