#include "ensemble/ensemble_training.hpp"

#include <chrono>

#include <fmt/format.h>

#include "core/parallel.hpp"

namespace leeway::ensemble {

std::vector<std::string> train_ensemble(const TrainingData& data, const EnsembleHeader& header,
                                        const EnsembleTraining& training, const nn::Kernels<float>& kernels,
                                        const TrainingProgress& progress) {
  using Clock = std::chrono::steady_clock;
  std::vector<std::string> notices(training.members.size());
  parallel_for(training.members.size(), training.jobs, [&](std::size_t i) {
    const int number = training.members[i];
    remove_unfinished(training.folder, number);
    if (training.resume && member_exists(training.folder, number)) {
      const Member done = read_member(training.folder, number, header);
      if (done.kernel != kernels.name)
        notices[i] = fmt::format(
            "member {} is kept as kernel '{}' trained it; kernel '{}' of this run would give other last digits", number,
            done.kernel, kernels.name);
      progress(number, header.config.epochs, done.training_curve.back());
      return;
    }
    std::optional<TrainingState> state;
    if (training.resume) state = read_checkpoint(training.folder, number, header);
    if (state) {
      if (state->member.kernel != kernels.name)
        notices[i] = fmt::format(
            "member {} was begun with kernel '{}' and goes on with '{}': its last digits differ from a run on one "
            "kernel. Use --kernel {} for the same bits.",
            number, state->member.kernel, kernels.name, state->member.kernel);
      progress(number, state->epochs_done, state->member.training_curve.back());
    } else {
      state = initial_training_state(data, header.seed, number, kernels);
    }
    Clock::time_point last_checkpoint = Clock::now();
    train(data, header.seed, kernels, *state, [&](const TrainingState& now) {
      progress(number, now.epochs_done, now.member.training_curve.back());
      const std::chrono::duration<double> elapsed = Clock::now() - last_checkpoint;
      if (elapsed.count() < training.checkpoint_interval_s || now.epochs_done == header.config.epochs) return;
      write_checkpoint(training.folder, now, header);
      last_checkpoint = Clock::now();
    });
    write_member(training.folder, state->member, header);
    remove_checkpoint(training.folder, number);
  });
  std::erase(notices, "");
  return notices;
}

}  // namespace leeway::ensemble
