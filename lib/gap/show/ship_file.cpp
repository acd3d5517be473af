#include "gap/show/ship_file.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "core/linear_algebra.hpp"
#include "effects/description.hpp"
#include "gap/decide/ship_file.hpp"
#include "gap/detect/effect_library.hpp"
#include "gap/fit/climb.hpp"
#include "gap/policy/policy.hpp"
#include "gap/result/inclusion.hpp"
#include "gap/result/numbers.hpp"
#include "gap/show/left_out.hpp"
#include "gap/show/module_changes.hpp"

namespace leeway::gap {
namespace {

using Modules = std::vector<std::string>;

// The answer's fit again, with the coefficients of some modules free and all others as the file has them.
std::optional<Fitted> fitted_alone(const Answered& of, const Modules& free) {
  Fitted result = of.answer;
  FittedNull& fit = result.fit;
  for (Eigen::Index i = 0; i < fit.coefficients(); ++i) {
    const UncertainParameter& p = fit.parameters[static_cast<std::size_t>(i)];
    if (std::any_of(free.begin(), free.end(), [&](const std::string& m) { return is_of_module(p.name, m); })) continue;
    fit.theta[i] = 0.0;
    fit.prior.hold(i, kPolicy.show.as_stated_log_sd * (p.is_absolute ? p.sd : 1.0));
  }
  FitOptions options;
  options.jobs = of.options.locate.jobs;
  try {
    Climb climb(of.campaign, fit, result.hypothesis, options, false);
    climb.until_converged(static_cast<int>(kPolicy.show.module_steps), Judged::nothing);
    climb.restore_inputs();
  } catch (const NumericalError&) {
    return std::nullopt;  // the simulator runs away
  }
  const Blocks blocks = blocks_of(of.campaign, fit, fit.noise, {0, nullptr}, options.jobs);
  result.fold_evidence = fold_evidence(blocks, of.comparison.folds(), fit.theta, fit.prior);
  result.kappa = 1.0;
  return result;
}

class FileJudge {
 public:
  FileJudge(const Answered& answered)
      : of_(answered),
        fit_(answered.answer.fit),
        names_(modules_of(std::span(fit_.parameters).first(static_cast<std::size_t>(count())))),
        usual_(usual_conditions(answered.campaign, fit_.smoothed)),
        keeps_course_(!Identifiable(answered.campaign, answered.null).has_answers()) {}

  // Whether nothing can be said of how hull and rudders answer, since a course was held by what the sensors say.
  bool keeps_course() const { return keeps_course_; }

  // Each module alone; then those that are off, one after another beside those before: what another module can do as
  // well is not told twice.
  void judge(ShipFile& file) const {
    const std::optional<Fitted> stated = fitted_alone(of_, {});
    if (!stated) return;
    std::tie(file.heldout_gain, file.heldout_gain_sd) = of_.comparison.gain(of_.answer, *stated);
    Tried with{{}, *stated, left_out(*stated)};
    std::vector<Tried> alone = tried_beside({}, names_, with);
    std::ranges::stable_sort(alone, std::greater(), [](const Tried& one) { return one.module.gain; });
    std::vector<std::string> followed;  // those with which the simulator does not run away
    for (const Tried& one : alone) {
      file.modules.push_back(one.module);
      followed.push_back(one.module.name);
    }
    if (keeps_course_) return;
    Modules off;
    for (std::vector<Tried> now = std::move(alone);;) {
      std::erase_if(now, [&](const Tried& one) {
        return !is_off(one.module, file.modules.size(), of_.options.locate.false_alarm);
      });
      if (now.empty()) break;
      with = std::move(*std::ranges::max_element(now, {}, [](const Tried& one) { return one.module.gain; }));
      off.push_back(with.module.name);
      file.off.push_back(with.module);
      std::erase(followed, with.module.name);
      now = tried_beside(off, followed, with);
    }
    for (CalibratedModule& module : file.off)
      module.changes =
          module_changes(of_.ship, module.name, with.fitted.fit.parameters, coefficients(with.fitted.fit.theta),
                         coefficients(posterior_covariance(with.fitted.fit)), usual_);
  }

  //   included  the probability that each is off by far more than stated, by its name there
  std::vector<FittedCoefficient> fitted_coefficients(const std::map<std::string, double>& included) const {
    const Eigen::MatrixXd covariance = of_.answer.kappa * posterior_covariance(fit_);
    std::vector<FittedCoefficient> result;
    for (Eigen::Index i = 0; i < count(); ++i) {
      const UncertainParameter& p = fit_.parameters[static_cast<std::size_t>(i)];
      const auto far_off = included.find(coefficient_in_inclusion(p.name));
      FittedCoefficient c{p.name,
                          p.is_absolute,
                          p.is_form,
                          !p.is_absolute && (p.may_be_far_more || p.may_be_far_less),
                          far_off == included.end() ? 0.0 : far_off->second,
                          p.sd,
                          fit_.theta[i],
                          std::sqrt(covariance(i, i)),
                          {kMissing, kMissing, kMissing}};
      const double reach = kPolicy.show.normal95 * c.shift_sd;
      if (!p.is_absolute) c.by = {std::exp(c.shift), std::exp(c.shift - reach), std::exp(c.shift + reach)};
      result.push_back(c);
    }
    return result;
  }

  // How many of the coefficients are known better than the file states: sum of 1 - variance after/before.
  double determined() const {
    FittedNull stated = fit_;
    stated.prior = fit_.stated;
    const Eigen::VectorXd before = stated.prior.sd().cwiseAbs2(), after = posterior_covariance(stated).diagonal();
    return static_cast<double>(count()) - coefficients(Eigen::VectorXd(after.cwiseQuotient(before))).sum();
  }

 private:
  Eigen::Index count() const { return fit_.coefficients(); }
  Eigen::VectorXd coefficients(const Eigen::VectorXd& of) const { return of.head(count()); }
  Eigen::MatrixXd coefficients(const Eigen::MatrixXd& of) const { return of.topLeftCorner(count(), count()); }
  struct Tried {
    CalibratedModule module;  // the last of those that are free
    Fitted fitted;
    std::vector<ShipOnRuns> left_out;  // fitted to all other parts, for free runs of each
  };
  // Each of some modules free beside others, against a fit with those others alone; without those with which the
  // simulator runs away.
  std::vector<Tried> tried_beside(const Modules& others, const Modules& names, const Tried& than) const {
    std::vector<Tried> result;
    for (const std::string& name : names) {
      Modules free = others;
      free.push_back(name);
      std::optional<Fitted> fitted = fitted_alone(of_, free);
      if (!fitted) continue;
      Tried one{{}, *std::move(fitted), {}};
      one.left_out = left_out(one.fitted);
      one.module.name = name;
      std::tie(one.module.gain, one.module.gain_sd) = of_.comparison.gain(one.fitted, than.fitted);
      one.module.helps_free_runs =
          is_beyond_chance(of_.campaign, of_.null.smoothed, than.left_out, one.left_out, of_.options.locate.jobs);
      result.push_back(std::move(one));
    }
    return result;
  }
  std::vector<ShipOnRuns> left_out(const Fitted& fitted) const {
    return leave_out_in_turn(of_.campaign, fitted.hypothesis, fitted.fit, of_.comparison.folds(),
                             of_.options.locate.jobs)
        .with_coefficients;
  }

  const Answered& of_;
  const FittedNull& fit_;
  const std::vector<std::string> names_;
  const UsualConditions usual_;
  const bool keeps_course_;
};

// "resistance at 1.18 m/s 19 % too high (57 N, 48 +- 2 N fit)".
std::string sentence_of(const ModuleChange& change) {
  const double sd = std::abs(change.after) * std::log(change.by.high / change.by.low) / (2.0 * kPolicy.show.normal95);
  const std::string name = change.where.empty() ? change.quantity : change.quantity + ' ' + change.where;
  if (change.unit == "1/s")
    return fmt::format("{} with {} instead of {} {}", name, rounded(change.after, sd), rounded(change.before, sd),
                       change.unit);
  const double off = 100.0 * (change.before / change.after - 1.0),
               off_sd = sd * std::abs(change.before) * 100.0 / (change.after * change.after);
  return fmt::format("{} {} % too {} ({} instead of {} {})", name, rounded(std::abs(off), off_sd),
                     off > 0.0 ? "high" : "low", rounded(std::abs(change.after), sd),
                     rounded(std::abs(change.before), sd), change.unit);
}

bool is_equal(const FileFactor& a, const FileFactor& b) {
  return std::abs(std::log(a.factor / b.factor)) < kPolicy.show.equal_factors;
}

// What may have happened to the ship instead, of a change that an effect of the catalogue makes as well.
std::string cause_of(const ModuleChange& change) {
  if (change.by_effect.empty()) return "";
  const EffectInfo& info = effect_named(change.by_effect).info;
  return std::string(change.by.factor < 1.0 ? info.cause_of_less : info.cause_of_more);
}

std::string sentence_of(const FittedCoefficient& c, bool is_stated) {
  if (c.is_form)
    return fmt::format("{} is {}: another form of the force than the file's; published ones differ by {:.2g}", c.name,
                       with_sd(c.shift, c.shift_sd), c.stated_sd);
  const char* known = is_stated ? "by the file it is known to" : "such coefficients are usually known to";
  if (c.is_absolute)
    return fmt::format("{} is off by {}; {} {:.2g}", c.name, with_sd(c.shift, c.shift_sd), known, c.stated_sd);
  return fmt::format("{} is {} times what the file has; {} {}", c.name, with_sd(c.by.factor, c.by.factor * c.shift_sd),
                     known, percent(c.stated_sd));
}

//   has_named  whether coefficients of the module are told by name
void add_findings(const CalibratedModule& module, bool has_named, ShipFile& file, std::vector<std::string>& told) {
  std::size_t count = 0;
  for (const ModuleChange& change : module.changes) {
    if (!change.by.is_off() || count == kPolicy.show.most_changes) continue;
    const std::string cause = cause_of(change);
    const std::string sentence =
        sentence_of(change) + (cause.empty() ? "" : fmt::format("; {} would do the same", cause));
    if (std::any_of(file.findings.begin(), file.findings.end(), [&](const ShipFileFinding& f) {
          return f.sentence == sentence || (f.name == module.name && is_equal(f.by, change.by));
        }))
      continue;  // hull and propeller make self-propulsion together; a rudder's moment is its force by a lever
    file.findings.push_back({module.name, change.by, kMissing, module.gain, sentence, cause});
    told.push_back(sentence);
    ++count;
  }
  if (count == 0) {
    file.findings.push_back(
        {module.name,
         {kMissing, kMissing, kMissing},
         kMissing,
         module.gain,
         fmt::format("{}coefficients of the {}, none of them by itself", has_named ? "other " : "", module.name)});
    told.push_back(file.findings.back().sentence);
  }
}

}  // namespace

ShipFile judge_ship_file(const Answered& answered, const Explanation& explanation) {
  const FileJudge judge(answered);
  ShipFile file;
  judge.judge(file);
  const bool is_stated = !answered.ship.uncertainty.empty() || answered.ship.coefficient_covariance.has_value();
  std::vector<std::string> told;
  const std::vector<FittedCoefficient> coefficients = judge.fitted_coefficients(inclusion(explanation));
  // Of a calibration the coefficients are told as they were fitted together.
  if (!explanation.calibration)
    for (const CalibratedModule& module : file.off)
      add_findings(module,
                   std::ranges::any_of(coefficients,
                                       [&](const auto& c) { return is_off(c) && is_of_module(c.name, module.name); }),
                   file, told);
  for (const FittedCoefficient& c : coefficients) {
    if (!is_off(c)) continue;
    const auto of = std::find_if(file.modules.begin(), file.modules.end(),
                                 [&](const CalibratedModule& m) { return is_of_module(c.name, m.name); });
    const double gain = of == file.modules.end() ? kMissing : of->gain;
    file.findings.push_back({c.name, c.by, c.is_absolute ? kMissing : c.stated_sd, gain, sentence_of(c, is_stated)});
    told.push_back(file.findings.back().sentence);
  }
  const bool together =
      explanation.calibration ? explanation.calibration->helps : !explanation.coefficient_factors.empty();
  if (told.empty() && together && !judge.keeps_course())
    told.emplace_back("several coefficients together, none of them alone");

  const Findings& findings = answered.findings;
  ShipFileFound found;
  found.is_off = !told.empty();
  found.converged = answered.answer.fit.report.converged;
  found.keeps_course = judge.keeps_course();
  found.is_spoiled =
      !findings.corrected && !(findings.audit.faults.empty() && findings.conventions.contradicted.empty());
  found.samples = answered.answer.fit.report.samples;
  found.determined = judge.determined();
  file.state = decide_ship_file(found);
  switch (file.state) {
    case ShipFileState::off:
      file.sentence = fmt::format("The ship file is off: {}.", fmt::join(told, "; "));
      break;
    case ShipFileState::as_stated:
      file.sentence = fmt::format("The ship file agrees with the recordings within what {}.",
                                  is_stated ? "it states" : "is usual for such coefficients");
      break;
    case ShipFileState::cannot_tell:
      file.findings.clear();
      file.sentence = found.is_spoiled   ? "Of the ship file nothing can be said before the sensors are corrected."
                      : !found.converged ? "Of the ship file nothing can be said: the fit has not converged."
                      : found.keeps_course
                          ? "A course was held all the time: how hull and rudders answer cannot be judged."
                          : "Too little was recorded to judge the ship file.";
      break;
  }
  return file;
}

}  // namespace leeway::gap
