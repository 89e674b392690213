#include "base/random.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace kantaro {
namespace {

constexpr int kDraws = 100'000;

std::vector<double> Draw(RandomStream stream, int count) {
  std::vector<double> draws;
  for (int i = 0; i < count; ++i) draws.push_back(stream.Uniform(0.0, 1.0));
  return draws;
}

double Mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double Covariance(const std::vector<double>& a, const std::vector<double>& b) {
  const double mean_a = Mean(a), mean_b = Mean(b);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - mean_a) * (b[i] - mean_b);
  return sum / static_cast<double>(a.size());
}

TEST(RandomStream, RepeatsItselfForTheSameSeedAndName) {
  EXPECT_EQ(Draw(RandomStream(7, "laser"), 100), Draw(RandomStream(7, "laser"), 100));
}

TEST(RandomStream, DiffersByName) {
  EXPECT_NE(Draw(RandomStream(7, "laser"), 4), Draw(RandomStream(7, "lasers"), 4));
}

TEST(RandomStream, DiffersBySeedInEitherHalfOfIt) {
  EXPECT_NE(Draw(RandomStream(7, "laser"), 4), Draw(RandomStream(8, "laser"), 4));
  EXPECT_NE(Draw(RandomStream(7, "laser"), 4), Draw(RandomStream(7 + (1ULL << 32), "laser"), 4));
}

// What one stream draws depends on nothing that another one drew before.
TEST(RandomStream, IsNotMovedByAnotherConsumer) {
  RandomStream other(7, "camera");
  (void)other.Normal(1.0);
  (void)other.Index(6);
  EXPECT_EQ(Draw(RandomStream(7, "laser"), 10), Draw(RandomStream(7, "laser"), 10));
}

// Two independent uniform streams: the correlation of n pairs has a standard deviation of 1/sqrt(n)
// = 0.0032.
TEST(RandomStream, IsUncorrelatedWithNeighboursInNameAndSeed) {
  const std::vector<double> laser = Draw(RandomStream(7, "laser"), kDraws);
  for (const auto& neighbour :
       {Draw(RandomStream(7, "laser2"), kDraws), Draw(RandomStream(8, "laser"), kDraws)}) {
    EXPECT_NEAR(Covariance(laser, neighbour) * 12.0, 0.0, 4.0 * 0.0032);
  }
}

// Mean 1/2 and variance 1/12; their standard errors over 100,000 draws are 0.0009 and 0.00024.
TEST(RandomStream, UniformHasTheMomentsOfAUniformVariable) {
  const std::vector<double> draws = Draw(RandomStream(1, "moments"), kDraws);
  EXPECT_NEAR(Mean(draws), 0.5, 4.0 * 0.0009);
  EXPECT_NEAR(Covariance(draws, draws), 1.0 / 12.0, 4.0 * 0.00024);
}

TEST(RandomStream, UniformStaysInItsHalfOpenRange) {
  RandomStream stream(3, "range");
  for (int i = 0; i < kDraws; ++i) {
    const double draw = stream.Uniform(-0.05, 0.05);
    ASSERT_GE(draw, -0.05);
    ASSERT_LT(draw, 0.05);
  }
}

// Of normal draws 68.27 % lie within one standard deviation and 95.45 % within two; standard error
// 0.15 %, 0.07 %.
TEST(RandomStream, NormalHasTheSpreadOfANormalVariable) {
  RandomStream stream(5, "noise");
  double sum = 0.0;
  int within_one = 0, within_two = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double draw = stream.Normal(0.02);
    ASSERT_TRUE(std::isfinite(draw));
    sum += draw;
    within_one += std::abs(draw) < 0.02;
    within_two += std::abs(draw) < 0.04;
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 4.0 * 0.02 / std::sqrt(kDraws));
  EXPECT_NEAR(within_one / double{kDraws}, 0.6827, 4.0 * 0.0015);
  EXPECT_NEAR(within_two / double{kDraws}, 0.9545, 4.0 * 0.0007);
}

// Each of six faces comes up n/6 times, with a standard deviation of sqrt(n · 1/6 · 5/6) = 118.
TEST(RandomStream, IndexIsAFairDie) {
  RandomStream stream(11, "die");
  std::array<int, 6> faces{};
  for (int i = 0; i < kDraws; ++i) ++faces.at(stream.Index(6));
  for (const int count : faces) EXPECT_NEAR(count, kDraws / 6.0, 4.0 * 118.0);
}

TEST(RandomStream, HasNoIndexIntoNothing) {
  RandomStream stream(1, "empty");
  EXPECT_THROW((void)stream.Index(0), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro
