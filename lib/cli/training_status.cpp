#include "cli/training_status.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "cli/progress.hpp"

namespace leeway::cli {
namespace {

using ensemble::MemberState;
constexpr std::array kStates{std::pair{MemberState::trained, "trained"}, std::pair{MemberState::training, "training"},
                             std::pair{MemberState::interrupted, "interrupted"},
                             std::pair{MemberState::waiting, "waiting"}};

std::string number_or_dash(const std::optional<double>& value) { return value ? fmt::format("{:.4g}", *value) : "-"; }

}  // namespace

std::string training_status_text(const std::string& folder, const ensemble::TrainingStatus& status) {
  std::string text = fmt::format("{:<7} {:<11} {:>13} {:>9} {:>9} {:>8}  {}\n", "member", "state", "epoch", "loss",
                                 "held-out", "left", "process");
  std::string counts;
  for (const auto& [state, name] : kStates) {
    const auto count = std::count_if(status.members.begin(), status.members.end(),
                                     [wanted = state](const auto& m) { return m.state == wanted; });
    if (count > 0) counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, name);
    for (const ensemble::MemberStatus& m : status.members) {
      if (m.state != state) continue;
      const ensemble::MemberProgress& p = m.progress;
      const std::string process = m.owner ? fmt::format("{} on {}, {} ago", m.owner->pid, m.owner->host,
                                                        duration(std::max(0.0, m.owner->age_s)))
                                          : "-";
      text += fmt::format("{:<7} {:<11} {:>13} {:>9} {:>9} {:>8}  {}\n", fmt::format("{:02}", m.number), name,
                          fmt::format("{}/{}", p.epochs_done, status.epochs), number_or_dash(p.loss),
                          number_or_dash(p.held_out_loss), p.seconds_left ? duration(*p.seconds_left) : "-", process);
    }
  }
  return text + fmt::format("{}: {} of {} members\n", folder, counts, status.members.size());
}

}  // namespace leeway::cli
