#pragma once

#include "nn/vector.hpp"

/// The matrix products of a network, with what follows each product done while its result is in registers.
///
/// A block of columns (windows, particles, gain pairs) are the lanes: activations stand as [feature][lane], some
/// vectors of lanes wide. Each lane is computed by itself, in the same order whatever stands beside it: its numbers do
/// not depend on the width of the block or on its place there. Few columns stand as [column][feature] instead, with the
/// features as the vector, and have the same numbers again.
namespace leeway::nn::LEEWAY_KERNEL {
namespace {

/// Rows of a product that are computed together; with two vectors of lanes the sums fill the registers.
#if defined(__AVX512F__)
constexpr int kRows = 8;
#elif defined(__AVX2__)
constexpr int kRows = 6;
#else
constexpr int kRows = 4;
#endif

/// Vectors of lanes that a product has sums for at a time.
constexpr int kTogether = 2;

/// Vectors that a group of features has where the features are the vector.
constexpr int kGroup = 2;

/// rows x cols weights in panels of kRows rows, each [column][row]; the last panel has the rows that are left.
///   weights  row i and column k at [i*row_step + k*column_step]
template <typename S>
inline void pack_panels(const S* weights, int rows, int cols, int row_step, int column_step, S* panels) {
  int row = 0;
  for (; row + kRows <= rows; row += kRows) {
    const S* from = weights + static_cast<long>(row) * row_step;
    for (int k = 0; k < cols; ++k, from += column_step)
      for (int i = 0; i < kRows; ++i) *panels++ = from[static_cast<long>(i) * row_step];
  }
  const S* from = weights + static_cast<long>(row) * row_step;
  for (int k = 0; k < cols; ++k, from += column_step)
    for (int i = 0; i < rows - row; ++i) *panels++ = from[static_cast<long>(i) * row_step];
}

/// Rows of P panels, R rows each, for V of the C vectors of lanes, the first of which is `first`.
template <int P, int R, int V, int C, typename S, typename Finish>
inline __attribute__((always_inline)) void panel_product(const S* panels, int cols, const S* bias, const S* in, int row,
                                                         int first, const Finish& finish) {
  constexpr int W = kWidth<S>;
  const long panel = static_cast<long>(R) * cols;
  Vector<S> sum[P * R][V];
#pragma GCC unroll 16
  for (int i = 0; i < P * R; ++i)
#pragma GCC unroll 2
    for (int v = 0; v < V; ++v) sum[i][v] = bias != nullptr ? broadcast(bias[row + i]) : Vector<S>{};
  in += first * W;
  for (int k = 0; k < cols; ++k) {
    Vector<S> x[V];
#pragma GCC unroll 2
    for (int v = 0; v < V; ++v) x[v] = load(in + v * W);
#pragma GCC unroll 2
    for (int p = 0; p < P; ++p)
#pragma GCC unroll 8
      for (int i = 0; i < R; ++i) {
        const Vector<S> w = broadcast(panels[p * panel + i]);
#pragma GCC unroll 2
        for (int v = 0; v < V; ++v) sum[p * R + i][v] = multiply_add<S>(w, x[v], sum[p * R + i][v]);
      }
    panels += R;
    in += C * W;
  }
#pragma GCC unroll 16
  for (int i = 0; i < P * R; ++i)
#pragma GCC unroll 2
    for (int v = 0; v < V; ++v) finish(((row + i) * C + first + v) * W, sum[i][v]);
}

/// The same for all C vectors of lanes: the panels stay in the cache meanwhile.
template <int P, int R, int C, typename S, typename Finish>
inline void rows_product(const S* panels, int cols, const S* bias, const S* in, int row, const Finish& finish) {
  constexpr int V = C < kTogether ? C : kTogether;
  for (int first = 0; first < C; first += V) panel_product<P, R, V, C>(panels, cols, bias, in, row, first, finish);
}

template <int R, int C, typename S, typename Finish>
inline void last_panel(int n, const S* panels, int cols, const S* bias, const S* in, int row, const Finish& finish) {
  if constexpr (R > 0) {
    if (n == R)
      rows_product<1, R, C>(panels, cols, bias, in, row, finish);
    else
      last_panel<R - 1, C>(n, panels, cols, bias, in, row, finish);
  }
}

/// finish(position, sum) for each vector of weights * in + bias; `in` is [cols][C vectors], position the place of the
/// vector in [rows][C vectors].
///   panels  from pack_panels
///   bias    [rows], or nullptr
template <int C, typename S, typename Finish>
inline void product(const S* panels, int rows, int cols, const S* bias, const S* in, const Finish& finish) {
  constexpr int P = C == 1 ? 2 : 1;  // one vector of lanes: two panels, for as many sums
  int row = 0;
  for (; row + P * kRows <= rows; row += P * kRows)
    rows_product<P, kRows, C>(panels + static_cast<long>(row) * cols, cols, bias, in, row, finish);
  if constexpr (P > 1)
    for (; row + kRows <= rows; row += kRows)
      rows_product<1, kRows, C>(panels + static_cast<long>(row) * cols, cols, bias, in, row, finish);
  last_panel<kRows - 1, C>(rows - row, panels + static_cast<long>(row) * cols, cols, bias, in, row, finish);
}

/// N columns, V vectors of features from `row` on.
template <int N, int V, typename S, typename Finish>
inline __attribute__((always_inline)) void column_product(const S* weights, int rows, int cols, const S* bias,
                                                          const S* in, int in_step, int row, const Finish& finish) {
  constexpr int W = kWidth<S>;
  Vector<S> sum[N][V];
#pragma GCC unroll 8
  for (int n = 0; n < N; ++n)
#pragma GCC unroll 2
    for (int v = 0; v < V; ++v) sum[n][v] = load(bias + row + v * W);
  weights += row;
  for (int k = 0; k < cols; ++k) {
    Vector<S> w[V];
#pragma GCC unroll 2
    for (int v = 0; v < V; ++v) w[v] = load(weights + v * W);
#pragma GCC unroll 8
    for (int n = 0; n < N; ++n) {
      const Vector<S> x = broadcast(in[n * in_step + k]);
#pragma GCC unroll 2
      for (int v = 0; v < V; ++v) sum[n][v] = multiply_add<S>(w[v], x, sum[n][v]);
    }
    weights += rows;
  }
#pragma GCC unroll 8
  for (int n = 0; n < N; ++n)
#pragma GCC unroll 2
    for (int v = 0; v < V; ++v) finish(n, row + v * W, sum[n][v]);
}

/// The same for at most N columns: finish(column, row, sum) for each vector of features.
///   weights  [cols][rows], rows a multiple of the vector's width
///   bias     [rows]
///   in       column n at [n*in_step]
template <int N, typename S, typename Finish>
inline void few_columns_product(int n, const S* weights, int rows, int cols, const S* bias, const S* in, int in_step,
                                const Finish& finish) {
  if constexpr (N > 0) {
    if (n < N) return few_columns_product<N - 1>(n, weights, rows, cols, bias, in, in_step, finish);
    int row = 0;
    for (; row + kGroup * kWidth<S> <= rows; row += kGroup * kWidth<S>)
      column_product<N, kGroup>(weights, rows, cols, bias, in, in_step, row, finish);
    for (; row < rows; row += kWidth<S>) column_product<N, 1>(weights, rows, cols, bias, in, in_step, row, finish);
  }
}

/// Vectors of features in the group that begins at `row`, of `rows` rows, a multiple of the vector's width.
template <typename S>
inline int vectors_in_group(int row, int rows) {
  const int left = (rows - row) / kWidth<S>;
  return left < kGroup ? left : kGroup;
}

/// Writes lanes [feature][lane] of one step as groups [group][sample][feature]: the samples of `step` of a chunk with
/// room for `samples`.
///   rows  a multiple of the vector's width
template <int C, typename S>
inline void append_samples(const S* lanes, int rows, int step, long samples, S* groups) {
  constexpr int W = kWidth<S>;
  for (int row = 0; row < rows; row += W) {
    const int begin = row / (kGroup * W) * (kGroup * W), width = vectors_in_group<S>(begin, rows) * W;
    S* to = groups + begin * samples + static_cast<long>(step) * C * W * width + (row - begin);
    for (int c = 0; c < C; ++c) {
      Vector<S> square[W];
#pragma GCC unroll 16
      for (int i = 0; i < W; ++i) square[i] = load(lanes + ((row + i) * C + c) * W);
      transpose<S>(square);
#pragma GCC unroll 16
      for (int i = 0; i < W; ++i) store<S>(to + (c * W + i) * width, square[i]);
    }
  }
}

/// Adds to R columns of a group's V vectors of rows of the weight gradient.
template <int R, int V, int C, typename S>
inline __attribute__((always_inline)) void gradient_tile(const S* group, int steps, const S* in, long in_step, S* out,
                                                         int out_rows) {
  constexpr int W = kWidth<S>, L = C * W;
  Vector<S> sum[R][V];
#pragma GCC unroll 8
  for (int r = 0; r < R; ++r)
#pragma GCC unroll 2
    for (int v = 0; v < V; ++v) sum[r][v] = load(out + static_cast<long>(r) * out_rows + v * W);
  for (int step = 0; step < steps; ++step) {
    for (int lane = 0; lane < L; ++lane) {
      Vector<S> d[V];
#pragma GCC unroll 2
      for (int v = 0; v < V; ++v) d[v] = load(group + v * W);
#pragma GCC unroll 8
      for (int r = 0; r < R; ++r) {
        const Vector<S> x = broadcast(in[r * L + lane]);
#pragma GCC unroll 2
        for (int v = 0; v < V; ++v) sum[r][v] = multiply_add<S>(x, d[v], sum[r][v]);
      }
      group += V * W;
    }
    in += in_step;
  }
#pragma GCC unroll 8
  for (int r = 0; r < R; ++r)
#pragma GCC unroll 2
    for (int v = 0; v < V; ++v) store<S>(out + static_cast<long>(r) * out_rows + v * W, sum[r][v]);
}

template <int R, int V, int C, typename S>
inline void last_gradient_tile(int n, const S* group, int steps, const S* in, long in_step, S* out, int out_rows) {
  if constexpr (R > 0) {
    if (n == R)
      gradient_tile<R, V, C>(group, steps, in, in_step, out, out_rows);
    else
      last_gradient_tile<R - 1, V, C>(n, group, steps, in, in_step, out, out_rows);
  }
}

template <int V, int C, typename S>
inline void gradient_of_group(const S* group, int steps, const S* in, int cols, long in_step, S* out, int out_rows) {
  int k = 0;
  for (; k + kRows <= cols; k += kRows)
    gradient_tile<kRows, V, C>(group, steps, in + static_cast<long>(k) * C * kWidth<S>, in_step,
                               out + static_cast<long>(k) * out_rows, out_rows);
  last_gradient_tile<kRows - 1, V, C>(cols - k, group, steps, in + static_cast<long>(k) * C * kWidth<S>, in_step,
                                      out + static_cast<long>(k) * out_rows, out_rows);
}

/// Adds the sums of a chunk's deltas to `out` [rows].
///   groups  from append_samples, `room` samples wide, of which `samples` are there
///   rows    a multiple of the vector's width
template <typename S>
inline void add_bias_gradient(const S* groups, long room, long samples, int rows, S* out) {
  constexpr int W = kWidth<S>;
  for (int row = 0; row < rows; row += kGroup * W) {
    const int vectors = vectors_in_group<S>(row, rows);
    for (int v = 0; v < vectors; ++v) {
      Vector<S> sum = load(out + row + v * W);
      for (long sample = 0; sample < samples; ++sample) sum += load(groups + row * room + (sample * vectors + v) * W);
      store<S>(out + row + v * W, sum);
    }
  }
}

/// Adds the gradient by the weights of a layer over a chunk of steps to `out` [cols][rows].
///   groups  the layer's deltas from append_samples, with room for `samples`
///   in      [cols][C vectors] of the first step, the next one in_step further
///   rows    a multiple of the vector's width
template <int C, typename S>
inline void add_weight_gradient(const S* groups, long samples, int steps, int rows, const S* in, int cols, long in_step,
                                S* out) {
  for (int row = 0; row < rows; row += kGroup * kWidth<S>) {
    const S* group = groups + row * samples;
    if (vectors_in_group<S>(row, rows) == kGroup)
      gradient_of_group<kGroup, C>(group, steps, in, cols, in_step, out + row, rows);
    else
      gradient_of_group<1, C>(group, steps, in, cols, in_step, out + row, rows);
  }
}

}  // namespace
}  // namespace leeway::nn::LEEWAY_KERNEL
