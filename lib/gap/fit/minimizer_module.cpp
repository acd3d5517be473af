// A module of its own, the only one that is linked with Ceres: see minimizer.hpp.
#include "gap/fit/minimizer_module.hpp"

#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>

namespace {

class Function final : public ceres::FirstOrderFunction {
 public:
  Function(const leeway::gap::Objective& objective, std::size_t count) : objective_(objective), count_(count) {}
  int NumParameters() const override { return static_cast<int>(count_); }
  bool Evaluate(const double* parameters, double* value, double* gradient) const override {
    return objective_(parameters, value, gradient);
  }

 private:
  const leeway::gap::Objective& objective_;
  std::size_t count_;
};

}  // namespace

extern "C" void leeway_minimize(const leeway::gap::Objective& objective, std::vector<double>& parameters,
                                const leeway::gap::MinimizerLimits& limits) {
  const ceres::GradientProblem problem(new Function(objective, parameters.size()));  // takes it
  ceres::GradientProblemSolver::Options solver;
  solver.line_search_direction_type = ceres::BFGS;
  solver.max_num_iterations = limits.most_iterations;
  solver.gradient_tolerance = limits.gradient_tolerance;
  solver.function_tolerance = limits.function_tolerance;
  solver.logging_type = ceres::SILENT;
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(solver, problem, parameters.data(), &summary);
}
