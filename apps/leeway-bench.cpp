// Times the hot paths on random data of the ensemble paper's shapes. One JSON line per benchmark on stdout: medians
// over repeats after a warm-up. Compare ratios from one run: other work on the machine moves all figures together.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <span>
#include <sys/resource.h>
#include <unistd.h>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/options.hpp"
#include "control/pd_sweep.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "core/statistics.hpp"
#include "dynamics/maneuvers.hpp"
#include "dynamics/observation_noise.hpp"
#include "ensemble/prediction_run.hpp"
#include "gap/gap_locate.hpp"
#include "io/trajectory_csv.hpp"

using namespace leeway;

namespace {

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

// Medians of the repeats, and how far these scatter.
struct Timing {
  double wall_s = 0.0, cpu_s = 0.0;
  double least_s = 0.0, most_s = 0.0;  // of the wall's
  io::Json wall() const { return {{"min", least_s}, {"median", wall_s}, {"max", most_s}}; }
};

// After one warm-up.
Timing time(int repeats, const std::function<void()>& work) {
  std::vector<double> wall, cpu;
  work();
  for (int i = 0; i < repeats; ++i) {
    const double c = cpu_seconds();
    const auto start = std::chrono::steady_clock::now();
    work();
    wall.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    cpu.push_back(cpu_seconds() - c);
  }
  const auto [least, most] = std::minmax_element(wall.begin(), wall.end());
  return {median(wall), median(cpu), *least, *most};
}

void print(const io::Json& json) { std::cout << json.dump() << std::endl; }

// Windows of smooth random motion with the inputs of the paper's ship: two rudders, a bow thruster, wind.
ensemble::TrainingData random_data(std::size_t windows) {
  const ensemble::TrainingConfig config;
  std::vector<Trajectory> recordings(windows);
  for (std::size_t i = 0; i < windows; ++i) {
    RandomStream random(1, "benchmark", i);
    Trajectory& t = recordings[i];
    t.name = t.file = fmt::format("random-{}", i);
    double psi = random.uniform(-3.0, 3.0);
    for (int k = 0; k < config.steps; ++k) {
      const double r = 0.05 * std::sin(0.1 * k + static_cast<double>(i));
      psi += r;
      const std::pair<Channel, double> row[] = {{Channel::t, k},
                                                {Channel::u, 0.3 + 0.1 * std::sin(0.05 * k)},
                                                {Channel::vm, 0.05 * std::cos(0.07 * k)},
                                                {Channel::r, r},
                                                {Channel::x0, 0.3 * k},
                                                {Channel::y0, 0.1 * k},
                                                {Channel::psi, psi},
                                                {Channel::delta_p, random.uniform(-1.8, 0.6)},
                                                {Channel::delta_s, random.uniform(-0.6, 1.8)},
                                                {Channel::n_bt, random.uniform(-30.0, 30.0)},
                                                {Channel::wind_speed, 1.0},
                                                {Channel::wind_dir, 0.5}};
      for (const auto& [channel, value] : row) t[channel].push_back(value);
    }
  }
  return ensemble::prepare_training_data(recordings, config);
}

template <typename S>
nn::AlignedVector<S> gradient_of(const nn::Kernels<S>& kernels, const ensemble::TrainingData& data,
                                 const ensemble::Member& member, const std::vector<std::size_t>& windows) {
  const ensemble::RolloutConstants<S> constants(data.inputs, data.config, member);
  const nn::KernelWorkspace<S> workspace(kernels);
  ensemble::WindowBatch<S> batch;
  batch.assign(data, windows.data(), windows.size());
  const nn::AlignedVector<S> parameters(member.parameters.begin(), member.parameters.end());
  nn::AlignedVector<S> gradient(parameters.size());
  kernels.loss_and_gradient(workspace.get(), constants.view(), batch.view(), parameters.data(), gradient.data());
  return gradient;
}

// Norm of the gradient's error by the norm of `exact`.
double relative_error(const nn::AlignedVector<float>& gradient, const nn::AlignedVector<double>& exact) {
  double difference = 0.0, square = 0.0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    difference += std::pow(static_cast<double>(gradient[i]) - exact[i], 2);
    square += exact[i] * exact[i];
  }
  return std::sqrt(difference / square);
}

// All kernels of this processor, unless one is named.
void bench_train(const std::string& kernel, std::size_t jobs, int repeats) {
  const ensemble::TrainingData data = random_data(32);
  std::vector<std::size_t> windows(32);
  for (std::size_t i = 0; i < windows.size(); ++i) windows[i] = i;
  const ensemble::Member first = ensemble::initial_training_state(data, 1, 0, nn::kernels("portable")).member;
  const nn::AlignedVector<double> exact = gradient_of(nn::kernels_double(), data, first, windows);
  for (const std::string& name : kernel.empty() ? nn::available_kernels() : std::vector{kernel}) {
    const nn::Kernels<float>& kernels = nn::kernels(name);
    constexpr long kPeakRepeats = 20'000'000;
    const double peak =
        kernels.multiply_adds(kPeakRepeats) / time(3, [&] { kernels.multiply_adds(kPeakRepeats); }).wall_s;
    // Every thread trains a member of its own: the step as it runs in ens-train.
    const auto step_time = [&](std::size_t batch_size) {
      struct Member {
        ensemble::TrainingState state;
        ensemble::RolloutConstants<float> constants;
        nn::KernelWorkspace<float> workspace;
        ensemble::WindowBatch<float> batch;
        nn::AlignedVector<float> gradient;
      };
      std::vector<std::unique_ptr<Member>> members;
      for (std::size_t j = 0; j < jobs; ++j) {
        ensemble::TrainingState state = ensemble::initial_training_state(data, 1, static_cast<int>(j), kernels);
        const std::size_t n = state.member.parameters.size();
        members.push_back(std::unique_ptr<Member>(new Member{state,
                                                             {data.inputs, data.config, state.member},
                                                             nn::KernelWorkspace<float>(kernels),
                                                             {},
                                                             nn::AlignedVector<float>(n)}));
      }
      return time(repeats, [&] {
        parallel_for(jobs, jobs, [&](std::size_t j) {
          Member& m = *members[j];
          m.batch.assign(data, windows.data(), batch_size);
          kernels.loss_and_gradient(m.workspace.get(), m.constants.view(), m.batch.view(),
                                    m.state.member.parameters.data(), m.gradient.data());
          kernels.adam({}, ++m.state.adam_steps, m.gradient.size(), m.gradient.data(), m.state.member.parameters.data(),
                       m.state.adam_m.data(), m.state.adam_v.data());
        });
      });
    };
    const Timing step32 = step_time(32), step15 = step_time(15);
    // Three products of equal size (forward, backward, weights) for each weight, column and step; the initial-state
    // network once for each window.
    const ensemble::TrainingState state = ensemble::initial_training_state(data, 1, 0, kernels);
    const double weights = static_cast<double>(nn::parameter_count(state.member.dynamics)),
                 start_weights = static_cast<double>(nn::parameter_count(state.member.initial_state));
    const double flops = static_cast<double>(jobs) * 3.0 * 2.0 * 32.0 * (99.0 * weights + start_weights);
    print({{"bench", "train"},
           {"path", kernels.name},
           {"kernel", kernels.name},
           {"path", kernels.name},  // as the reports of performance call it
           {"jobs", jobs},
           {"ms_step32", 1e3 * step32.wall_s},
           {"cpu_ms_step32", 1e3 * step32.cpu_s},
           {"ms_step15", 1e3 * step15.wall_s},
           {"wall_s", step32.wall()},
           {"gflops", 1e-9 * flops / step32.wall_s},
           {"fp32_peak_gflops", 1e-9 * peak * static_cast<double>(jobs)},
           {"fraction_of_fp32_peak", flops / step32.wall_s / peak / static_cast<double>(jobs)},
           {"gradient_error", relative_error(gradient_of(kernels, data, first, windows), exact)},
           {"rss_mb", peak_memory_mb()}});
  }
}

// An untrained ensemble of the paper's size: the time of an evaluation does not depend on the weights.
ensemble::Ensemble random_ensemble(const ensemble::TrainingData& data, const nn::Kernels<float>& kernels, int members) {
  std::vector<ensemble::Member> drawn;
  drawn.reserve(static_cast<std::size_t>(members));
  for (int m = 0; m < members; ++m) drawn.push_back(ensemble::initial_training_state(data, 1, m, kernels).member);
  return {ensemble::make_header(data, 1, {}), std::move(drawn), kernels};
}

void bench_predict(const nn::Kernels<float>& kernels, std::size_t jobs, int repeats) {
  const ensemble::TrainingData data = random_data(23);
  const ensemble::Ensemble model = random_ensemble(data, kernels, 15);
  const std::vector<ensemble::SequenceTask> tasks = ensemble::sequences_of(data.stretches, 100, false);
  for (const auto& [mode, sampling] :
       {std::pair{"ts-inf", ensemble::Sampling::ts_infinity}, {"ts1", ensemble::Sampling::ts1}}) {
    const ensemble::PredictionOptions options{100, sampling, Integrator::rk4, 1};
    const Timing t = time(repeats, [&] {
      parallel_for(jobs, jobs, [&](std::size_t j) {
        ensemble::EnsembleEvaluator evaluator(model);
        const std::size_t begin = j * tasks.size() / jobs, end = (j + 1) * tasks.size() / jobs;
        ensemble::predict_sequences(evaluator, model, std::span(tasks).subspan(begin, end - begin), options);
      });
    });
    print({{"bench", "predict"},
           {"mode", mode},
           {"kernel", kernels.name},
           {"path", kernels.name},
           {"jobs", jobs},
           {"s_total", t.wall_s},
           {"wall_s", t.wall()},
           {"cpu_s", t.cpu_s}});
  }
}

void bench_pd(const nn::Kernels<float>& kernels, std::size_t jobs, int repeats) {
  const ensemble::Ensemble model = random_ensemble(random_data(23), kernels, 15);
  const Ship ship = read_ship("vectwin-3m");
  std::vector<control::PdGains> gains;
  for (int kp = 5; kp <= 100; kp += 5)
    for (int kd = 5; kd <= 100; kd += 5) gains.push_back({static_cast<double>(kp), static_cast<double>(kd)});
  const Timing t = time(std::min(repeats, 1), [&] { control::pd_sweep(ship, model, gains, {}, 100, 1, jobs, false); });
  print({{"bench", "pd"},
         {"kernel", kernels.name},
         {"path", kernels.name},
         {"jobs", jobs},
         {"s_total", t.wall_s},
         {"wall_s", t.wall()},
         {"cpu_s", t.cpu_s}});
}

void bench_sim(int repeats) {
  for (const char* name : {"vectwin-3m", "kvlcc2-l7", "esso-osaka-3m"}) {
    const Ship ship = read_ship(name);
    const Timing t = time(std::max(repeats, 20), [&] {
      const auto maneuver = zigzag(ship, deg_to_rad(20.0), deg_to_rad(20.0));
      simulate(SimulatedShip(ship), *maneuver, Vec2<double>(0.5, 0.3), {0.1, 1.0, 1000.0});
    });
    print({{"bench", "sim"}, {"ship", name}, {"ms_per_1000s", 1e3 * t.wall_s}, {"wall_s", t.wall()}});
  }
}

// Recordings of random maneuvers at 1 Hz with the usual noise.
void bench_gap(std::size_t jobs, int repeats) {
  const Ship ship = read_ship("vectwin-3m");
  std::vector<Trajectory> recordings;
  for (std::uint64_t i = 0; i < 4; ++i) {
    const auto maneuver = random_orders(ship, RandomStream(1, "bench gap", i));
    const Trajectory truth = simulate(SimulatedShip(ship), *maneuver, Vec2<double>(0.5, 0.3), {0.1, 1.0, 1000.0});
    recordings.push_back(observed(truth, read_noise("paper-model-scale"), RandomStream(1, "bench gap noise", i)));
    recordings.back().name = recordings.back().file = fmt::format("random-{}", i);
  }
  const Timing t = time(std::min(repeats, 3), [&] {
    std::vector<Trajectory> copy = recordings;
    gap::GapLocateOptions options;
    options.jobs = jobs;
    gap::gap_locate(ship, copy, options);
  });
  print({{"bench", "gap"},
         {"ship", ship.name},
         {"jobs", jobs},
         {"s_per_4000s", t.wall_s},
         {"wall_s", t.wall()},
         {"cpu_s", t.cpu_s},
         {"rss_mb", peak_memory_mb()}});
}

// A recording of 50 MB through the plain reader, and through a columns map that only renames.
void bench_read(int repeats) {
  constexpr std::size_t kRows = 600'000;
  Trajectory recording;
  RandomStream stream(1, "bench read");
  const std::vector<Channel> channels{Channel::u,  Channel::vm,  Channel::r,     Channel::x0,
                                      Channel::y0, Channel::psi, Channel::delta, Channel::n_p};
  for (std::size_t i = 0; i < kRows; ++i) {
    recording[Channel::t].push_back(0.1 * static_cast<double>(i));
    for (const Channel channel : channels) recording[channel].push_back(1e-6 * std::round(1e6 * stream.uniform(-1, 1)));
  }
  const std::string path =
      fmt::format("{}/leeway-bench-{}.csv", std::filesystem::temp_directory_path().string(), getpid());
  io::write_trajectory(path, recording);
  const double size_mb = 1e-6 * static_cast<double>(std::filesystem::file_size(path));
  io::ColumnsMap map;
  for (const Channel channel : channels) {
    const io::KnownColumn known = *io::known_column(column_name(channel));
    map.columns.push_back({channel, {column_name(channel), 0}, known.unit, known.unit.factor, 0.0});
  }
  const io::KnownColumn time_column = *io::known_column("t_s");
  map.columns.push_back({Channel::t, {"t_s", 0}, time_column.unit, 1.0, 0.0});
  const Timing plain = time(std::min(repeats, 5), [&] { io::read_trajectory(path); });
  const Timing mapped = time(std::min(repeats, 5), [&] { io::read_trajectory(path, &map); });
  std::filesystem::remove(path);
  print({{"bench", "read"},
         {"mb", size_mb},
         {"wall_s", plain.wall()},
         {"cpu_s_per_100mb", 100.0 * plain.cpu_s / size_mb},
         {"cpu_s_per_100mb_map", 100.0 * mapped.cpu_s / size_mb},
         {"map_by_plain", mapped.cpu_s / plain.cpu_s}});
}

// A kernel that the benchmark would ignore ends the program: figures must be of what was asked for.
void check_options(const CLI::App& app, const std::string& what) {
  const bool is_without_network = what == "sim" || what == "gap" || what == "read";
  if (app.count("--kernel") > 0 && is_without_network)
    throw UsageError(fmt::format("--kernel does not apply to the benchmark '{}': it evaluates no network", what));
}

}  // namespace

int main(int argc, char** argv) try {
  std::string what, kernel;
  int repeats = 7;
  cli::CommonOptions common;
  CLI::App app{"Time the hot paths; one JSON line per benchmark on stdout.", "leeway-bench"};
  app.add_option("benchmark", what, "train, predict, pd, sim, gap or read")
      ->required()
      ->check(CLI::IsMember({"train", "predict", "pd", "sim", "gap", "read"}));
  app.add_option("--repeats", repeats,
                 "measurements after a warm-up, whose median is printed, beside the least and the most as wall_s; at "
                 "most 5 by read, 3 by gap, 1 by pd, at "
                 "least 20 by sim")
      ->check(cli::at_least(1))
      ->capture_default_str();
  app.add_option("--kernel", kernel, "auto, avx512, avx2 or portable, for train, predict and pd")
      ->default_str("all of this processor for train, else auto");
  cli::add_common_options(app, common);
  if (const auto exit_code = cli::parse(app, argc, argv, common)) return *exit_code;
  check_options(app, what);
  const nn::Kernels<float>& kernels = nn::kernels(kernel.empty() ? "auto" : kernel);
  if (what == "train") bench_train(kernel, common.jobs, repeats);
  if (what == "predict") bench_predict(kernels, common.jobs, repeats);
  if (what == "pd") bench_pd(kernels, common.jobs, repeats);
  if (what == "sim") bench_sim(repeats);
  if (what == "read") bench_read(repeats);
  if (what == "gap") bench_gap(common.jobs, repeats);
  return cli::kOk;
} catch (...) {
  return cli::report_current_exception("leeway-bench");
}
