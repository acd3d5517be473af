#include "ensemble/ensemble_training.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "io/files.hpp"

namespace leeway::ensemble {
namespace {

constexpr double kReportInterval_s = 2.0;
constexpr int kHeldOutEvaluations = 100;

class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  void restart() { start_ = Clock::now(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

// The training of one member, from what lies in the folder to its file.
class MemberTraining {
 public:
  MemberTraining(const TrainingData& data, const EnsembleHeader& header, const EnsembleTraining& training,
                 const nn::Kernels<float>& kernels, const TrainingReports& reports, int number)
      : data_(data_of_member(data, header.seed, number)),
        header_(header),
        training_(training),
        kernels_(kernels),
        reports_(reports),
        number_(number),
        owner_(training.folder, number) {}

  bool run() {
    remove_unfinished(training_.folder, number_);
    std::optional<TrainingState> state;
    if (training_.resume) state = read_checkpoint(training_.folder, number_, header_);
    if (state) {
      if (!nn::give_same_bits(state->member.kernel, kernels_.name))
        reports_.warning(fmt::format(
            "member {} was begun with kernel '{}' and continues with '{}': its last digits differ from a run on one "
            "kernel. Use --kernel {} for the same bits.",
            number_, state->member.kernel, kernels_.name, state->member.kernel));
    } else {
      state = initial_training_state(data_, header_.seed, number_, kernels_);
    }
    state->member.own_base = own_base_of(data_);
    if (data_.has_drawn_base) io::write_text(member_ship_path(training_.folder, number_), data_.base->text());
    share_before_ = share_done(*state);
    note_progress(*state);
    owner_.report(progress_);
    if (state->epochs_done > 0) reports_.progress(number_, progress_);
    if (!train(data_, header_.seed, kernels_, *state, [&](const TrainingState& now) { return after_step(now); }))
      return false;
    write([&](const auto& check) { write_member(training_.folder, state->member, header_, check); });
    remove_checkpoint(training_.folder, number_);
    return true;
  }

 private:
  double share_done(const TrainingState& state) const {
    const auto windows = static_cast<double>(data_.windows_of_epoch(state.epochs_done).size());
    return (state.epochs_done + static_cast<double>(state.windows_done) / windows) / header_.config.epochs;
  }

  void note_progress(const TrainingState& state) {
    progress_.epochs_done = state.epochs_done;
    if (!state.member.training_curve.empty()) progress_.loss = state.member.training_curve.back();
    const double share = share_done(state);
    if (share > share_before_) progress_.seconds_left = running_.seconds() * (1.0 - share) / (share - share_before_);
  }

  bool after_step(const TrainingState& state) {
    const int epochs = header_.config.epochs;
    note_progress(state);
    if (state.windows_done == 0) {
      if (training_.held_out != nullptr &&
          (state.epochs_done % std::max(1, epochs / kHeldOutEvaluations) == 0 || state.epochs_done == epochs))
        progress_.held_out_loss = mean_loss(*training_.held_out, state.member, kernels_, data_.base.get());
      reports_.progress(number_, progress_);
    }
    if (state.epochs_done == epochs) return true;
    const auto checkpoint = [&](const auto& check) { write_checkpoint(training_.folder, state, header_, check); };
    if (training_.stop && training_.stop()) {
      write(checkpoint);
      return false;
    }
    try {
      if (since_report_.seconds() >= kReportInterval_s) {
        since_report_.restart();
        write([&](const auto&) { owner_.report(progress_); });
      }
      if (since_checkpoint_.seconds() >= training_.checkpoint_interval_s) {
        since_checkpoint_.restart();
        write(checkpoint);
        warned_ = false;
      }
    } catch (const Displaced&) {
      throw;
    } catch (const IoError& error) {  // a full disk may have room again before the training ends
      if (!warned_)
        reports_.warning(fmt::format("{}; training continues, and a kill would take it back to the checkpoint before",
                                     error.what()));
      warned_ = true;
    }
    return true;
  }

  // A new owner removes half-written files of the old one: that is no failure of the disk.
  template <typename Write>
  void write(const Write& write) const {
    try {
      write([this] { owner_.check(); });
    } catch (const IoError&) {
      owner_.check();
      throw;
    }
  }

  const TrainingData data_;
  const EnsembleHeader& header_;
  const EnsembleTraining& training_;
  const nn::Kernels<float>& kernels_;
  const TrainingReports& reports_;
  int number_;
  MemberOwner owner_;
  MemberProgress progress_;
  double share_before_ = 0.0;  // of the training, done by earlier processes
  Stopwatch running_, since_report_, since_checkpoint_;
  bool warned_ = false;
};

// The ship of a member that is kept: its file may have been lost or changed, and it is drawn as it was.
void restore_own_base(const TrainingData& data, const EnsembleHeader& header, const std::string& folder,
                      const Member& member) {
  if (!member.own_base) return;
  const std::string path = member_ship_path(folder, member.number);
  std::error_code error;
  if (std::filesystem::exists(path, error) && io::sha256(io::read_text(path)) == member.own_base->sha256) return;
  const std::string text = data_of_member(data, header.seed, member.number).base->text();
  if (io::sha256(text) != member.own_base->sha256)
    throw InputError(member_path(folder, member.number), 0, "/base/sha256",
                     "is not that of the ship which this member's number draws; train it anew");
  io::write_text(path, text);
}

}  // namespace

bool train_ensemble(const TrainingData& data, const EnsembleHeader& header, const EnsembleTraining& training,
                    const nn::Kernels<float>& kernels, const TrainingReports& reports) {
  std::mutex mutex;
  const TrainingReports one_at_a_time{[&](int member, const MemberProgress& progress) {
                                        const std::lock_guard lock(mutex);
                                        if (reports.progress) reports.progress(member, progress);
                                      },
                                      [&](const std::string& warning) {
                                        const std::lock_guard lock(mutex);
                                        if (reports.warning) reports.warning(warning);
                                      }};
  std::atomic<bool> all_done{true};
  parallel_for(training.members.size(), training.jobs, [&](std::size_t i) {
    const int number = training.members[i];
    if (training.resume && member_exists(training.folder, number)) {
      const Member done = read_member(training.folder, number, header);
      if (!nn::give_same_bits(done.kernel, kernels.name))
        one_at_a_time.warning(fmt::format(
            "member {} is kept as kernel '{}' trained it; kernel '{}' of this run would give other last digits", number,
            done.kernel, kernels.name));
      restore_own_base(data, header, training.folder, done);
      remove_remains(training.folder, number);
      one_at_a_time.progress(number, {header.config.epochs, done.training_curve.back(), {}, {}});
      return;
    }
    const bool stops = training.stop && training.stop();
    if (stops || !MemberTraining(data, header, training, kernels, one_at_a_time, number).run()) all_done = false;
  });
  return all_done;
}

}  // namespace leeway::ensemble
