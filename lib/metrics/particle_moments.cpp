#include "metrics/particle_moments.hpp"

#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "io/prediction_csv.hpp"

namespace leeway {
namespace {

constexpr std::size_t kMostNumbers = 10'000'000;  // of steps or particles: what lies above is a damaged file

// Spreads particle numbers over all bits, so that different sets of them have different sums.
std::size_t spread(std::size_t x) {
  x = (x + 0x9e3779b97f4a7c15ULL) * 0xbf58476d1ce4e5b9ULL;
  return (x ^ (x >> 29)) * 0x94d049bb133111ebULL;
}

void check_number(const io::CsvReader& csv, const char* column, std::size_t number) {
  if (number >= kMostNumbers)
    throw InputError(csv.file(), csv.line(), fmt::format("column '{}'", column),
                     fmt::format("expected a number below {}, got {}", kMostNumbers, number));
}

void add_row(PredictedSequence& sequence, const io::PredictionRow& row, const io::CsvReader& csv) {
  check_number(csv, "step", row.step);
  check_number(csv, "particle", row.particle);
  if (row.step >= sequence.steps.size()) sequence.steps.resize(row.step + 1);
  PredictedSequence::Step& step = sequence.steps[row.step];
  if (step.moments.count() == 0) {
    step.t_s = row.t_s;
    step.line = csv.line();
  }
  if (std::abs(step.t_s - row.t_s) > kSameTime_s)
    throw InputError(csv.file(), csv.line(), "column 't_s'",
                     fmt::format("got {} s, but other particles of recording '{}', sequence {}, step {} are at {} s",
                                 row.t_s, row.recording, row.sequence, row.step, step.t_s));
  step.moments.add(row.nu, row.eta(0), row.eta(1));
  step.particles.push_back({row.nu, row.member});
  step.particle_hash += spread(row.particle);

  if (row.particle >= sequence.member_of_particle.size())
    sequence.member_of_particle.resize(row.particle + 1, kNoMember);
  std::size_t& member = sequence.member_of_particle[row.particle];
  if (member == kNoMember) member = row.member;
  if (member != row.member) sequence.member_changes = true;
}

void check_complete(const PredictedRecording& recording, std::size_t number, const PredictedSequence& sequence) {
  std::size_t particles = 0, hash = 0;
  for (std::size_t i = 0; i < sequence.member_of_particle.size(); ++i)
    if (sequence.member_of_particle[i] != kNoMember) {
      ++particles;
      hash += spread(i);
    }
  for (std::size_t k = 0; k < sequence.steps.size(); ++k) {
    const PredictedSequence::Step& step = sequence.steps[k];
    if (step.moments.count() == particles && step.particle_hash == hash) {
      if (k == 0 || step.t_s > sequence.steps[k - 1].t_s) continue;
      throw InputError(recording.file, step.line, "column 't_s'",
                       fmt::format("time must increase with the steps of recording '{}', sequence {}, but {} s of step "
                                   "{} follows {} s",
                                   recording.name, number, step.t_s, k, sequence.steps[k - 1].t_s));
    }
    throw InputError(
        recording.file,
        fmt::format("recording '{}', sequence {}, step {}: expected each of the sequence's {} particles once, found {} "
                    "row(s){}",
                    recording.name, number, k, particles, step.moments.count(),
                    step.moments.count() == particles ? ", some of one particle" : ""));
  }
}

}  // namespace

void ParticleMoments::add(const Vec3<double>& nu, double x0, double y0) {
  if (count_ == 0) first_ = nu;
  ++count_;
  const double n = static_cast<double>(count_);
  const Vec3<double> before = nu - first_ - mean_;
  mean_ += before / n;
  comoment_ += (n - 1.0) / n * (before * before.transpose()).eval();  // symmetric to the bit
  const Vec2<double> off = Vec2<double>(x0, y0) - mean_position_;
  mean_position_ += off / n;
  squared_off_ += (n - 1.0) / n * off.squaredNorm();
}

Eigen::Matrix3d ParticleMoments::covariance() const {
  if (count_ == 0) return Eigen::Matrix3d::Zero();
  return comoment_ / static_cast<double>(count_);
}

std::vector<PredictedRecording> read_prediction(const std::string& path, const std::set<std::string>& known,
                                                bool may_be_empty) {
  io::PredictionReader reader(path);
  std::map<std::string, PredictedRecording, std::less<>> recordings;
  PredictedRecording* recording = nullptr;
  PredictedSequence* sequence = nullptr;
  std::size_t sequence_number = 0;
  io::PredictionRow row;
  while (reader.next(row)) {
    // Rows of one sequence mostly stand together: look up only where they do not.
    if (recording == nullptr || recording->name != row.recording) {
      auto found = recordings.find(row.recording);
      if (found == recordings.end()) {
        const std::string name{row.recording};
        if (!known.contains(name))
          throw InputError(path, reader.csv().line(), "column 'recording'",
                           fmt::format("no truth for '{}' among the {} given with --truth", name, known.size()));
        found = recordings.emplace(name, PredictedRecording{name, path, {}, {}, {}, {}}).first;
      }
      recording = &found->second;
      sequence = nullptr;
    }
    if (sequence == nullptr || sequence_number != row.sequence) {
      sequence = &recording->sequences[row.sequence];
      sequence_number = row.sequence;
    }
    add_row(*sequence, row, reader.csv());
    recording->members.insert(row.member);
  }
  if (recordings.empty() && !may_be_empty)
    throw InputError(path, reader.csv().line() + 1, "", "no data row below the header");
  std::vector<PredictedRecording> result;
  for (auto& [name, found] : recordings) {
    for (const auto& [number, one] : found.sequences) check_complete(found, number, one);
    result.push_back(std::move(found));
  }
  return result;
}

}  // namespace leeway
