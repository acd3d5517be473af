#include "gap/locate/block_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "gap/filter/reference_units.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

constexpr std::size_t kActiveBlocks = kPolicy.locate.active_blocks;

// The blocks of all stretches, of about equal length.
struct Grid {
  std::vector<Block> blocks;
  std::vector<std::size_t> first;  // block of each stretch, and one past the last

  std::size_t count(std::size_t stretch) const { return first[stretch + 1] - first[stretch]; }
};

Grid grid_of(const Campaign& campaign, const FittedNull& fit) {
  const auto least =
      static_cast<std::size_t>(std::ceil(kPolicy.locate.block_s * campaign.time_scale() / campaign.step_s));
  const std::size_t size =
      std::max({kPolicy.locate.least_points, least, campaign.points() / kPolicy.locate.most_blocks + 1});
  Grid grid;
  for (std::size_t s = 0; s < fit.stretches.size(); ++s) {
    const std::size_t n = fit.stretches[s].path.size(), count = std::max<std::size_t>(1, n / size);
    grid.first.push_back(grid.blocks.size());
    for (std::size_t i = 0; i < count; ++i) grid.blocks.push_back({s, i * n / count, (i + 1) * n / count});
  }
  grid.first.push_back(grid.blocks.size());
  return grid;
}

// What one stretch says.
struct Part {
  Eigen::VectorXd b;         // by block and kind
  Eigen::MatrixXd F, cross;  // among blocks, lower triangle; of theta with the blocks
  Evidence of_theta;
};

// The filter along one stretch, with columns for theta and, one slot after another, for the latest blocks.
class BlockFilter {
 public:
  BlockFilter(const LinearStretch& stretch, const Noise& noise, const std::vector<Module>& modules,
              const std::optional<Model<double>>& null, const Vec3<double>& unit, Eigen::Index p)
      : stretch_(stretch),
        modules_(modules),
        null_(null),
        unit_(unit),
        p_(p),
        kinds_(3 + static_cast<int>(modules.size())),
        filter_(stretch, noise, p + static_cast<Eigen::Index>(kActiveBlocks) * kinds_) {}

  //   first, count  the stretch's blocks
  Part run(const Block* first, std::size_t count) {
    const auto columns = static_cast<Eigen::Index>(count) * kinds_;
    Part part;
    part.b = Eigen::VectorXd::Zero(columns);
    part.F = Eigen::MatrixXd::Zero(columns, columns);
    part.cross = Eigen::MatrixXd::Zero(p_, columns);
    std::size_t block = 0;
    for (std::size_t k = 0; k < stretch_.path.size(); ++k) {
      if (k > 0) {
        filter_.predict(k - 1);
        filter_.columns.topLeftCorner(kShipStates, p_) += stretch_.steps[k - 1].G;
        if (k - 1 >= first[block].end) {
          ++block;
          filter_.columns.middleCols(slot(block), kinds_).setZero();
        }
        act(k - 1, slot(block));
      }
      take(k, block, part);
    }
    return part;
  }

 private:
  Eigen::Index slot(std::size_t block) const { return p_ + static_cast<Eigen::Index>(block % kActiveBlocks) * kinds_; }

  // Accelerations and gains during a step.
  void act(std::size_t step, Eigen::Index slot) {
    for (int axis = 0; axis < 3; ++axis)
      filter_.columns.col(slot + axis).head<kShipStates>() +=
          stretch_.steps[step].A.col(kErrorStart + axis) * unit_[axis];
    const std::vector<StepInputs<double>>& inputs = stretch_.data->inputs[step];
    const double h = stretch_.data->dt_s(step) / static_cast<double>(inputs.size());
    const Vec6 without = null_ ? advance<double>(*null_, stretch_.path[step], inputs, h) : Vec6::Zero();
    for (std::size_t m = 0; m < modules_.size(); ++m)
      filter_.columns.col(slot + 3 + static_cast<Eigen::Index>(m)).head<kShipStates>() +=
          stretch_.steps[step].answered(advance<double>(modules_[m].scaled, stretch_.path[step], inputs, h) - without) /
          kPolicy.locate.gain_step;
  }

  // What the measurements of a point say.
  void take(std::size_t k, std::size_t block, Part& part) {
    filter_.update(k, [&](const Filter::Taken& taken, const auto& row) {
      const std::size_t oldest = block + 1 >= kActiveBlocks ? block + 1 - kActiveBlocks : 0;
      for (std::size_t i = oldest; i <= block; ++i) {
        const auto row_i = row.segment(slot(i), kinds_);
        const Eigen::Index at = static_cast<Eigen::Index>(i) * kinds_;
        part.b.segment(at, kinds_) += taken.z * row_i.transpose();
        part.cross.middleCols(at, kinds_).noalias() += row.head(p_).transpose() * row_i;
        for (std::size_t j = oldest; j <= i; ++j)
          part.F.block(at, static_cast<Eigen::Index>(j) * kinds_, kinds_, kinds_).noalias() +=
              row_i.transpose() * row.segment(slot(j), kinds_);
      }
    });
  }

  const LinearStretch& stretch_;
  const std::vector<Module>& modules_;
  const std::optional<Model<double>>& null_;
  const Vec3<double>& unit_;
  const Eigen::Index p_;
  const int kinds_;
  Filter filter_;
};

// Puts the stretches together; the parameters take what they can.
void join(const FittedNull& fit, const std::vector<Part>& parts, BlockEvidence& result) {
  const Eigen::Index p = fit.theta.size(), all = static_cast<Eigen::Index>(result.blocks.size()) * result.kinds;
  Evidence total(p);
  for (const Part& part : parts) total += part.of_theta;
  const Eigen::LLT<Eigen::MatrixXd> factor(total.F + fit.prior.precision());
  Eigen::MatrixXd cross(p, all);
  result.b.resize(all);
  result.F = Eigen::MatrixXd::Zero(all, all);
  Eigen::Index at = 0;
  for (const Part& part : parts) {
    const Eigen::Index n = part.b.size();
    result.b.segment(at, n) = part.b;
    result.F.block(at, at, n, n) = part.F.selfadjointView<Eigen::Lower>();
    cross.middleCols(at, n) = part.cross;
    at += n;
  }
  const Eigen::MatrixXd of_theta = factor.solve(cross);
  // Their pull is that of the fit, which events do not take part in: else they would shift the parameters and show all
  // over.
  result.b -= of_theta.transpose() * (fit.total.b - fit.prior.pull(fit.theta));
  result.F_given = result.F;
  result.F -= cross.transpose() * of_theta;
}

}  // namespace

std::vector<Module> modules_of(const Campaign& campaign, const FittedNull& fit) {
  if (campaign.ensemble) return {};
  Model<double> null(campaign.ship);
  apply_uncertainty(null, fit.theta);
  std::vector<Module> modules;
  for (const std::string& name : null.modules()) {
    if (null.is_of_wind(name) && !campaign.has_wind) continue;
    modules.push_back({name, null});
    modules.back().scaled.scale_module(name, 1.0 + kPolicy.locate.gain_step);
  }
  return modules;
}

BlockEvidence block_evidence(const Campaign& campaign, const FittedNull& fit, const std::vector<Module>& modules,
                             std::size_t jobs) {
  Noise noise = fit.noise;
  noise.knows_events = false;
  noise.knows_spread = !campaign.ensemble;
  const Grid grid = grid_of(campaign, fit);
  const Vec3<double> unit = reference_acceleration(campaign.ship);
  std::optional<Model<double>> null;
  if (!modules.empty()) apply_uncertainty(null.emplace(campaign.ship), fit.theta);
  std::vector<Part> parts(fit.stretches.size());
  parallel_for(parts.size(), jobs, [&](std::size_t s) {
    parts[s] = BlockFilter(fit.stretches[s], noise, modules, null, unit, fit.theta.size())
                   .run(&grid.blocks[grid.first[s]], grid.count(s));
    parts[s].of_theta = evidence(fit.stretches[s], noise);
  });
  BlockEvidence result;
  result.blocks = grid.blocks;
  result.kinds = 3 + static_cast<int>(modules.size());
  join(fit, parts, result);
  return result;
}

}  // namespace leeway::gap
