#pragma once

#include "nn/products.hpp"

/// Products in AMX tiles. Each number is the sum of two bf16, x = high + low to 2^-17 of x, and a product of numbers
/// three products of bf16 summed in fp32: high high + high low + low high. LEEWAY_EMULATED_TILES computes the same in
/// software.
namespace leeway::nn::LEEWAY_KERNEL {
namespace {

constexpr int kTile = 16;       // rows of a tile, and its columns as 32-bit numbers
constexpr int kTileDepth = 32;  // bf16 in a row: terms of a sum that one tile holds
constexpr int kTileSize = 256;  // 32-bit numbers in a tile

static_assert(kWidth<float> == kTile, "a vector is a row of a tile");

#ifdef LEEWAY_EMULATED_TILES
class Tiles {
 public:
  template <int T>
  void zero() {
    __builtin_memset(tiles_[T], 0, sizeof tiles_[T]);
  }
  template <int T>
  void load(const void* from, long row_bytes) {
    for (int r = 0; r < kTile; ++r) __builtin_memcpy(tiles_[T][r], static_cast<const char*>(from) + r * row_bytes, 64);
  }
  template <int T>
  void store(void* to, long row_bytes) const {
    for (int r = 0; r < kTile; ++r) __builtin_memcpy(static_cast<char*>(to) + r * row_bytes, tiles_[T][r], 64);
  }
  // T[m][n] += A[m][2k] B[k][2n] + A[m][2k + 1] B[k][2n + 1] for all k.
  template <int T, int A, int B>
  void multiply_add() {
    for (int m = 0; m < kTile; ++m)
      for (int k = 0; k < kTile; ++k)
        for (int n = 0; n < kTile; ++n)
          for (int odd = 0; odd < 2; ++odd) tiles_[T][m][n] += part(tiles_[A][m][k], odd) * part(tiles_[B][k][n], odd);
  }

 private:
  static float part(float pair, int odd) {
    unsigned bits = 0;
    __builtin_memcpy(&bits, &pair, sizeof bits);
    bits = odd != 0 ? bits & 0xffff0000U : bits << 16;
    __builtin_memcpy(&pair, &bits, sizeof bits);
    return pair;
  }
  alignas(64) float tiles_[8][kTile][kTile];
};
#else
// The processor's eight tiles; configured while an object lives.
class Tiles {
 public:
  Tiles() {
    struct {
      unsigned char palette = 1, start_row = 0, reserved[14] = {};
      unsigned short row_bytes[16] = {64, 64, 64, 64, 64, 64, 64, 64};
      unsigned char rows[16] = {16, 16, 16, 16, 16, 16, 16, 16};
    } configuration;
    __asm__ volatile("" ::"r"(&configuration) : "memory");  // GCC 12 does not see what the next line reads
    _tile_loadconfig(&configuration);
  }
  ~Tiles() { _tile_release(); }
  Tiles(const Tiles&) = delete;
  Tiles& operator=(const Tiles&) = delete;

// The intrinsics want the tile's number as text. Memory that they read and write is made known to the compiler.
#define LEEWAY_FOR_TILE(T, N, statement) \
  if constexpr (T == N) statement
#define LEEWAY_FOR_TILES(T, operation) \
  LEEWAY_FOR_TILE(T, 0, operation(0)); \
  LEEWAY_FOR_TILE(T, 1, operation(1)); \
  LEEWAY_FOR_TILE(T, 2, operation(2)); \
  LEEWAY_FOR_TILE(T, 3, operation(3)); \
  LEEWAY_FOR_TILE(T, 4, operation(4)); \
  LEEWAY_FOR_TILE(T, 5, operation(5)); \
  LEEWAY_FOR_TILE(T, 6, operation(6)); \
  LEEWAY_FOR_TILE(T, 7, operation(7))
  template <int T>
  void zero() {
#define LEEWAY_ZERO(n) _tile_zero(n)
    LEEWAY_FOR_TILES(T, LEEWAY_ZERO);
#undef LEEWAY_ZERO
  }
  template <int T>
  void load(const void* from, long row_bytes) {
    __asm__ volatile("" ::: "memory");
#define LEEWAY_LOAD(n) _tile_loadd(n, from, row_bytes)
    LEEWAY_FOR_TILES(T, LEEWAY_LOAD);
#undef LEEWAY_LOAD
  }
  template <int T>
  void store(void* to, long row_bytes) const {
#define LEEWAY_STORE(n) _tile_stored(n, to, row_bytes)
    LEEWAY_FOR_TILES(T, LEEWAY_STORE);
#undef LEEWAY_STORE
    __asm__ volatile("" ::: "memory");
  }
  // T += A B; sums are in tiles 0 to 3, A in 4 and 5, B in 6 and 7.
  template <int T, int A, int B>
  void multiply_add() {
    static_assert(T == (A - 4) * 2 + (B - 6), "the pairs that are written out below");
    if constexpr (T == 0) _tile_dpbf16ps(0, 4, 6);
    if constexpr (T == 1) _tile_dpbf16ps(1, 4, 7);
    if constexpr (T == 2) _tile_dpbf16ps(2, 5, 6);
    if constexpr (T == 3) _tile_dpbf16ps(3, 5, 7);
  }
#undef LEEWAY_FOR_TILES
#undef LEEWAY_FOR_TILE
};
#endif

using Bits = IntegerVector<float>;

// bf16 in the upper halves: high is x rounded, low what that leaves.
inline void split(Vector<float> x, Bits& high, Bits& low) {
  const auto rounded = [](Vector<float> v) {
    return (reinterpret_cast<Bits>(v) + 0x8000) & static_cast<int>(0xffff0000U);
  };
  high = rounded(x);
  low = rounded(x - reinterpret_cast<Vector<float>>(high));
}

// Two bf16 in the upper halves as a pair; the first one lies first in memory.
inline Bits pair(Bits first, Bits second) { return ((first >> 16) & 0xffff) | second; }

inline void store_bits(int* to, Bits value) { *reinterpret_cast<Bits*>(to) = value; }

// A row of 32 numbers as 32 bf16.
inline void split_row(Vector<float> first, Vector<float> second, int* high, int* low) {
  Bits h[2], l[2];
  split(first, h[0], l[0]);
  split(second, h[1], l[1]);
  const Bits even{0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30}, odd = even + 1;
  store_bits(high, pair(__builtin_shuffle(h[0], h[1], even), __builtin_shuffle(h[0], h[1], odd)));
  store_bits(low, pair(__builtin_shuffle(l[0], l[1], even), __builtin_shuffle(l[0], l[1], odd)));
}

/// Whether a layer is made of whole tiles, forwards and backwards.
inline bool fits_tiles(int inputs, int outputs) { return inputs % kTileDepth == 0 && outputs % kTileDepth == 0; }

/// rows x cols weights, as pack_panels takes them, to tiles [row/16][col/32], each a tile of the high and one of the
/// low parts.
inline void pack_tiles(const float* weights, int rows, int cols, int row_step, int column_step, int* tiles) {
  for (int row = 0; row < rows; row += kTile)
    for (int k = 0; k < cols; k += kTileDepth, tiles += 2 * kTileSize)
      for (int i = 0; i < kTile; ++i) {
        Vector<float> part[2];
        const float* from = weights + static_cast<long>(row + i) * row_step + static_cast<long>(k) * column_step;
        for (int j = 0; j < kTileDepth; ++j) part[j / kTile][j % kTile] = from[static_cast<long>(j) * column_step];
        split_row(part[0], part[1], tiles + i * kTile, tiles + kTileSize + i * kTile);
      }
}

// Adds to 2 x N tiles of sums over `depth` tiles; the next ones of A and B lie a_step and b_step further.
template <int N>
inline void tile_sums(Tiles& tiles, const int* const (&a)[2], long a_step, const int* const (&b)[2], long b_step,
                      int depth) {
  for (int k = 0; k < depth; ++k) {
    const long at_a = k * a_step, at_b = k * b_step;
    const auto multiply = [&] {
      tiles.multiply_add<0, 4, 6>();
      tiles.multiply_add<2, 5, 6>();
      if constexpr (N == 2) {
        tiles.multiply_add<1, 4, 7>();
        tiles.multiply_add<3, 5, 7>();
      }
    };
    tiles.load<6>(b[0] + at_b, 64);
    if constexpr (N == 2) tiles.load<7>(b[1] + at_b, 64);
    tiles.load<4>(a[0] + at_a + kTileSize, 64);
    tiles.load<5>(a[1] + at_a + kTileSize, 64);
    multiply();  // low high
    tiles.load<4>(a[0] + at_a, 64);
    tiles.load<5>(a[1] + at_a, 64);
    multiply();  // high high
    tiles.load<6>(b[0] + at_b + kTileSize, 64);
    if constexpr (N == 2) tiles.load<7>(b[1] + at_b + kTileSize, 64);
    multiply();  // high low
  }
}

/// As product(), of weights from pack_tiles.
///   scratch  room for 2 * rows of `in` + 1024 numbers
template <int C, typename Finish>
inline void tile_product(const int* weights, int rows, int cols, const float* bias, const float* in, int* scratch,
                         const Finish& finish) {
  // Pairs of features: [col/32][vector of lanes], a tile of high parts and one of low.
  const int depth = cols / kTileDepth;
  for (int k = 0; k < cols; k += 2)
    for (int c = 0; c < C; ++c) {
      Bits high[2], low[2];
      split(load(in + (k * C + c) * kTile), high[0], low[0]);
      split(load(in + ((k + 1) * C + c) * kTile), high[1], low[1]);
      int* tile = scratch + ((k / kTileDepth) * C + c) * 2 * kTileSize + k % kTileDepth / 2 * kTile;
      store_bits(tile, pair(high[0], high[1]));
      store_bits(tile + kTileSize, pair(low[0], low[1]));
    }
  float* sums = reinterpret_cast<float*>(scratch + static_cast<long>(depth) * C * 2 * kTileSize);
  Tiles tiles;
  for (int row = 0; row < rows; row += 2 * kTile) {
    const int* upper = weights + static_cast<long>(row / kTile) * depth * 2 * kTileSize;
    tiles.zero<0>();
    tiles.zero<1>();
    tiles.zero<2>();
    tiles.zero<3>();
    tile_sums<C>(tiles, {upper, upper + static_cast<long>(depth) * 2 * kTileSize}, 2 * kTileSize,
                 {scratch, scratch + (C - 1) * 2 * kTileSize}, C * 2 * kTileSize, depth);
    tiles.store<0>(sums, C * 64);
    tiles.store<2>(sums + kTile * C * kTile, C * 64);
    if constexpr (C == 2) {
      tiles.store<1>(sums + kTile, C * 64);
      tiles.store<3>(sums + kTile * C * kTile + kTile, C * 64);
    }
    for (int i = 0; i < 2 * kTile; ++i)
      for (int c = 0; c < C; ++c) {
        const Vector<float> start = bias != nullptr ? broadcast(bias[row + i]) : Vector<float>{};
        finish(((row + i) * C + c) * kTile, load(sums + (i * C + c) * kTile) + start);
      }
  }
}

/// Writes deltas [rows][32 lanes] of one step as tiles of sample pairs [row/16][step], for chunks of `steps`.
inline void append_sample_tiles(const float* lanes, int rows, int step, int steps, int* tiles) {
  for (int row = 0; row < rows; row += kTile) {
    int* tile = tiles + static_cast<long>(row / kTile * steps + step) * 2 * kTileSize;
    Vector<float> square[2][kTile];
    for (int i = 0; i < kTile; ++i) {
      alignas(64) int high[kTile], low[kTile];
      split_row(load(lanes + (row + i) * 2 * kTile), load(lanes + (row + i) * 2 * kTile + kTile), high, low);
      square[0][i] = load(reinterpret_cast<const float*>(high));
      square[1][i] = load(reinterpret_cast<const float*>(low));
    }
    for (int part = 0; part < 2; ++part) {
      transpose<float>(square[part]);
      for (int i = 0; i < kTile; ++i)
        store<float>(reinterpret_cast<float*>(tile + part * kTileSize + i * kTile), square[part][i]);
    }
  }
}

/// As add_weight_gradient(), without the biases, of deltas from append_sample_tiles.
///   scratch  room for cols * steps * 32 numbers
inline void add_tile_gradient(const int* deltas, int chunk, int steps, int rows, const float* in, int cols,
                              long in_step, int* scratch, float* out) {
  for (int k = 0; k < cols; ++k)
    for (int step = 0; step < steps; ++step) {
      const float* from = in + step * in_step + k * 2 * kTile;
      int* tile = scratch + static_cast<long>(k / kTile * steps + step) * 2 * kTileSize + k % kTile * kTile;
      split_row(load(from), load(from + kTile), tile, tile + kTileSize);
    }
  Tiles tiles;
  const long row_bytes = 4L * rows;
  for (int k = 0; k < cols; k += 2 * kTile)
    for (int row = 0; row < rows; row += 2 * kTile) {
      float* sums = out + static_cast<long>(k) * rows + row;
      tiles.load<0>(sums, row_bytes);
      tiles.load<1>(sums + kTile, row_bytes);
      tiles.load<2>(sums + kTile * rows, row_bytes);
      tiles.load<3>(sums + kTile * rows + kTile, row_bytes);
      const int* a = scratch + static_cast<long>(k / kTile * steps) * 2 * kTileSize;
      const int* b = deltas + static_cast<long>(row / kTile * chunk) * 2 * kTileSize;
      tile_sums<2>(tiles, {a, a + static_cast<long>(steps) * 2 * kTileSize}, 2 * kTileSize,
                   {b, b + static_cast<long>(chunk) * 2 * kTileSize}, 2 * kTileSize, steps);
      tiles.store<0>(sums, row_bytes);
      tiles.store<1>(sums + kTile, row_bytes);
      tiles.store<2>(sums + kTile * rows, row_bytes);
      tiles.store<3>(sums + kTile * rows + kTile, row_bytes);
    }
}

}  // namespace
}  // namespace leeway::nn::LEEWAY_KERNEL
