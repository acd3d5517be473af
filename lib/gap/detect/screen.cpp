#include "gap/detect/screen.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"
#include "gap/detect/gains_of_nothing.hpp"
#include "gap/detect/score_test.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// What a candidate changes in the steps of one recording.
struct Sides {
  std::optional<EffectSide> at_start;
  std::vector<std::optional<EffectSlope>> coordinates;
};

Sides sides_of(const Candidate& candidate, const Campaign& campaign, const Hypothesis& so_far,
               const Eigen::VectorXd& known, const Eigen::VectorXd& plain_theta, std::size_t recording) {
  Sides sides;
  Hypothesis hypothesis = so_far;
  hypothesis.effects.insert(hypothesis.effects.end(), candidate.effects.begin(), candidate.effects.end());
  const RecordedInputs& recorded = campaign.recorded_inputs[recording];
  const Ship ship = campaign.ship_in(recording);
  const RudderResponse like = rudder_response_of(so_far.applied_to(ship, known, recording));
  const auto side = [&](const Eigen::VectorXd& z) {
    Eigen::VectorXd all(known.size() + z.size());
    all << known, z;
    return EffectSide(hypothesis.applied_to(ship, all, recording), plain_theta, recorded, like);
  };
  Eigen::Index j = 0;
  const auto side_at = [&](double off) {
    return side(candidate.z + off * Eigen::VectorXd::Unit(candidate.z.size(), j));
  };
  for (const FreeEffect& effect : candidate.effects) {
    const bool acts = effect.recording().value_or(recording) == recording;
    if (acts && !sides.at_start) sides.at_start = side(candidate.z);
    for (const double difference : effect.differences()) {
      sides.coordinates.emplace_back();
      if (acts) sides.coordinates.back().emplace(side_at, difference);
      ++j;
    }
  }
  return sides;
}

}  // namespace

std::vector<Candidate> candidates_of(const std::string& effect, const Ship& ship,
                                     std::vector<FreeEffect::Choice> choices) {
  std::vector<Candidate> result;
  const FreeEffect plain(effect, ship, choices.front());
  const auto add = [&](double towards_deg, const Eigen::VectorXd& z) {
    Candidate candidate;
    for (FreeEffect::Choice& choice : choices) {
      choice.towards_deg = towards_deg;
      candidate.effects.emplace_back(effect, ship, choice);
    }
    candidate.z = z.replicate(static_cast<Eigen::Index>(choices.size()), 1);
    result.push_back(std::move(candidate));
  };
  constexpr double half = 0.5 * static_cast<double>(kPolicy.detect.compass_starts);  // of the compass
  const Eigen::VectorXd median = Eigen::VectorXd::Zero(plain.size());
  if (!choices.front().priors.empty()) {
    add(choices.front().towards_deg, median);
  } else if (const auto neutral = plain.neutral()) {
    add(0.0, *neutral);
    // As a wind, of which in calm air nothing shows from where it may come.
    for (int k = 0; k < kPolicy.detect.compass_starts && search_start(effect) == SearchStart::compass; ++k)
      add(0.0, kPolicy.detect.first_wind * Eigen::Vector2d(std::cos(k * kPi / half), std::sin(k * kPi / half)));
  } else if (plain.has_bare_direction()) {
    // From a weak force one linear step does not reach a strong one, nor from a strong one a weak one.
    Eigen::VectorXd strong = median;
    strong(plain.log_strengths()).setConstant(kPolicy.detect.start_strengths.back());
    for (const Eigen::VectorXd& z : {median, strong})
      for (int k = 0; k < kPolicy.detect.compass_starts; ++k) add(180.0 / half * k, z);
  } else {
    for (const double z : kPolicy.detect.start_strengths) add(0.0, median.array() + z);
  }
  return result;
}

EffectScreen::EffectScreen(const Campaign& campaign, const FittedNull& from, const Hypothesis& so_far,
                           std::vector<Candidate> candidates, double share, std::vector<PriorWidths> widths,
                           const ScreenOptions& options)
    : so_far_(so_far), candidates_(std::move(candidates)), theta_(from.theta), effects_(from.effects) {
  const Eigen::Index coefficients = theta_.size() - 1 - effects_;
  theta_.head(coefficients) *= share;
  const Eigen::VectorXd plain_theta = without_effects(theta_, effects_), known = theta_.segment(coefficients, effects_);
  Eigen::Index count = 0;
  for (const Candidate& candidate : candidates_) {
    first_.push_back(theta_.size() + count);
    count += candidate.z.size() + 1;
  }
  std::vector<std::vector<Sides>> sides(campaign.recordings.size());
  parallel_for(sides.size(), options.jobs, [&](std::size_t r) {
    for (const Candidate& candidate : candidates_)
      sides[r].push_back(sides_of(candidate, campaign, so_far, known, plain_theta, r));
  });
  Noise noise = from.noise;
  noise.knows_events = options.knows_events;
  std::vector<Evidence> parts(from.stretches.size());
  parallel_for(parts.size(), options.jobs, [&](std::size_t s) {
    const std::size_t recording = campaign.stretches[s].recording;
    // With the known effects, and the rudders as they follow then.
    const EffectColumns columns(campaign, so_far, known, plain_theta, recording);
    const auto data = std::make_shared<Stretch>(campaign.stretches[s]);
    LinearStretch linear = from.stretches[s];
    linear.data = data;
    if (columns.response() != rudder_response_of(campaign.ship_in(recording))) columns.set_inputs_of(*data);
    if (share != 1.0) {
      std::vector<Vec3<double>> events = linear.event_scale;
      linear = linearize(columns.ship(), data, linear.path, plain_theta);
      linear.event_scale = std::move(events);
      if (effects_ > 0) columns.add_to(linear);
    }
    const EffectSide without(columns.ship(), plain_theta, campaign.recorded_inputs[recording], columns.response());
    const MoreColumns more = [&](std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) {
      // Only inputs that are shifted in time need what takes several times longer.
      const auto by_steps = [&](const auto& of) { return options.whole_steps || of.has_other_inputs(); };
      const Vec6 push = without.push(linear, k);
      std::optional<Vec6> step;
      Eigen::Index column = 0;
      for (const Sides& one : sides[recording]) {
        for (const auto& slope : one.coordinates) {
          if (!slope)
            out.col(column++).setZero();
          else
            out.col(column++) = by_steps(*slope) ? slope->step(linear, k) : slope->push(linear, k);
        }
        if (!one.at_start) {
          out.col(column++).setZero();
        } else if (!by_steps(*one.at_start)) {
          out.col(column++) = one.at_start->push(linear, k) - push;
        } else {
          if (!step) step = without.step(linear, k);
          out.col(column++) = one.at_start->step(linear, k) - *step;
        }
      }
    };
    parts[s] = evidence(linear, noise, count, more);
  });
  total_ = Evidence(theta_.size() + count);
  for (const Evidence& part : parts) total_ += part;
  const Eigen::Index n = theta_.size();
  file_.emplace(total_.F.topLeftCorner(n, n), theta_, std::move(widths));
}

EffectScreen::Judged EffectScreen::judge(const std::vector<std::size_t>& set) const {
  Judged result;
  const Eigen::Index n = theta_.size();
  std::vector<double> z;
  // What the candidates do at their starts is there: it moves the scores.
  result.score = total_.b;
  double log_likelihood = total_.log_likelihood;
  for (const std::size_t c : set) {
    const Eigen::Index count = candidates_[c].z.size(), start = first_[c] + count;
    for (Eigen::Index i = 0; i < count; ++i) {
      result.columns.push_back(first_[c] + i);
      z.push_back(candidates_[c].z[i]);
    }
    log_likelihood += result.score[start] - 0.5 * total_.F(start, start);
    result.score -= total_.F.col(start);
  }
  MoreCoordinates& more = result.more;
  more.z = Eigen::Map<const Eigen::VectorXd>(z.data(), static_cast<Eigen::Index>(z.size()));
  more.score = result.score(result.columns);
  more.with_theta = total_.F(Eigen::seqN(0, n), result.columns);
  more.own = total_.F(result.columns, result.columns);
  if (result.score.head(n).allFinite() && more.score.allFinite() && more.with_theta.allFinite() && more.own.allFinite())
    result.file = file_->with(log_likelihood, result.score.head(n), more);
  else
    result.file.log_evidence = -std::numeric_limits<double>::infinity();
  return result;
}

double EffectScreen::log_evidence(const std::vector<std::size_t>& set) const { return judge(set).file.log_evidence; }

std::vector<double> EffectScreen::gains_of_nothing(std::size_t draws, std::uint64_t seed) const {
  // Columns along which the simulator runs away say nothing.
  Evidence finite = total_;
  for (Eigen::Index i = theta_.size(); i < finite.b.size(); ++i) {
    if (std::isfinite(finite.b[i]) && std::isfinite(finite.F(i, i))) continue;
    finite.b[i] = 0.0;
    finite.F.row(i).setZero();
    finite.F.col(i).setZero();
  }
  std::vector<LinearCandidate> alone;
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    if (candidates_[c].effects.front().recording()) continue;
    const Eigen::Index first = first_[c] - theta_.size();
    alone.push_back({first, candidates_[c].z, first + candidates_[c].z.size()});
  }
  return gap::gains_of_nothing(project(finite, theta_, judge({}).file.likeliest.prior), alone, draws, seed);
}

Start EffectScreen::start(const std::vector<std::size_t>& set) const {
  const Judged judged = judge(set);
  const Eigen::Index n = theta_.size(), added = judged.more.z.size();
  Start result{so_far_, Eigen::VectorXd(n + added), judged.file.log_evidence};
  result.theta << theta_.head(n - 1), judged.more.z, theta_.tail(1);
  for (const std::size_t c : set)
    result.hypothesis.effects.insert(result.hypothesis.effects.end(), candidates_[c].effects.begin(),
                                     candidates_[c].effects.end());
  if (!std::isfinite(result.log_evidence)) return result;
  std::vector<Eigen::Index> places(static_cast<std::size_t>(n) - 1);  // in the evidence, in the order of theta
  std::iota(places.begin(), places.end(), Eigen::Index{0});
  places.insert(places.end(), judged.columns.begin(), judged.columns.end());
  places.push_back(n - 1);
  const ThetaPrior prior = judged.file.likeliest.prior.with(n - 1, Eigen::VectorXd::Ones(added));
  const Eigen::VectorXd step =
      (total_.F(places, places) + prior.precision()).llt().solve(judged.score(places) - prior.pull(result.theta));
  if (!step.allFinite()) return result;
  const Eigen::Index coefficients = n - 1 - effects_, effects = effects_ + added;
  const double too_long =
      std::max({1.0, step.head(coefficients).cwiseAbs().maxCoeff() / kPolicy.detect.longest_log_step,
                step.segment(coefficients, effects).cwiseAbs().maxCoeff() / kPolicy.detect.longest_start});
  result.theta += step / too_long;
  return result;
}

bool is_shifted(const FittedNull& fit) {
  return std::any_of(fit.report.parameters.begin(), fit.report.parameters.end(),
                     [](const ParameterShift& p) { return std::abs(p.shift_sd) > kPolicy.detect.shifted_sd; });
}

std::vector<Start> starts_of(const std::string& effect, const Campaign& campaign, const FittedNull& from,
                             std::size_t jobs, const Hypothesis& so_far, std::vector<FreeEffect::Choice> choices) {
  std::vector<Start> starts;
  const std::vector<Candidate> candidates = candidates_of(effect, campaign.ship, std::move(choices));
  for (const double share : {1.0, 0.0}) {
    if (share == 0.0 && !is_shifted(from)) break;
    const EffectScreen screen(campaign, from, so_far, candidates, share, {{.prior = from.prior}}, {jobs});
    for (std::size_t i = 0; i < candidates.size(); ++i) starts.push_back(screen.start({i}));
  }
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.log_evidence > b.log_evidence; });
  return starts;
}

}  // namespace leeway::gap
