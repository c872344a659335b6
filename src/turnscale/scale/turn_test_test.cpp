// SPDX-License-Identifier: MIT
#include "turnscale/scale/turn_test.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "turnscale/base/random.h"
#include "turnscale/base/refused_field.h"

namespace turnscale {
namespace {

/// Turns that all deviate alike, their squares adding up to `chi_squared`, and differ by `difference` in scale.
TurnTestInput Alike(int turns, double chi_squared, double difference = 0.2) {
  TurnTestInput input;
  input.deviations.assign(turns, std::sqrt(chi_squared / turns));
  input.chi_squared = chi_squared;
  input.degrees_of_freedom = turns - 1;
  input.differences.assign(turns, difference);
  input.weights.assign(turns, 1.0);
  return input;
}

struct Quantile {
  double probability;  // of a larger value
  int degrees;
  double value;
};

// From tables of the chi-squared distribution.
constexpr Quantile kTable[] = {{0.05, 10, 18.307},  {0.05, 30, 43.773},   {0.01, 1, 6.635},   {0.01, 5, 15.086},
                               {0.01, 20, 37.566},  {0.001, 2, 13.816},   {0.001, 5, 20.515}, {0.001, 10, 29.588},
                               {0.001, 20, 45.315}, {0.001, 100, 149.449}};

TEST(TurnTest, ContradictionIsWhatChanceRarelyGives) {
  for (const Quantile& quantile : kTable) {
    TurnTestOptions options;
    options.min_probability = quantile.probability;
    const auto contradicted = [&](double chi_squared) {
      const TurnTest test = TestTurns(Alike(quantile.degrees + 1, chi_squared), options);
      EXPECT_EQ(test.degrees_of_freedom, quantile.degrees);
      EXPECT_NEAR(test.chi_squared, chi_squared, 1e-9);
      return test.contradicted;
    };
    EXPECT_FALSE(contradicted(0.96 * quantile.value)) << quantile.probability << ' ' << quantile.degrees;
    EXPECT_TRUE(contradicted(1.04 * quantile.value)) << quantile.probability << ' ' << quantile.degrees;
  }
}

TEST(TurnTest, TheDefaultLevelIsOnePercent) {
  EXPECT_FALSE(TestTurns(Alike(21, 0.98 * 37.566), {}).contradicted);
  EXPECT_TRUE(TestTurns(Alike(21, 1.02 * 37.566), {}).contradicted);
}

TEST(TurnTest, ChanceIsCalledAContradictionAsOftenAsItMay) {
  Random random(3);
  TurnTestOptions options;
  options.min_probability = 0.02;
  int contradicted = 0;
  constexpr int kDraws = 20000;
  for (int draw = 0; draw < kDraws; ++draw) {
    TurnTestInput input = Alike(7, 1);
    double mean = 0;
    for (double& deviation : input.deviations) mean += (deviation = random.Gaussian()) / 7;
    for (double& deviation : input.deviations) deviation -= mean;  // the scale that was fitted to them
    input.chi_squared = 0;
    for (const double deviation : input.deviations) input.chi_squared += deviation * deviation;
    contradicted += TestTurns(input, options).contradicted;
  }
  EXPECT_NEAR(contradicted / static_cast<double>(kDraws), 0.02, 0.004);
}

TEST(TurnTest, OneTurnThatDeviatesByFarIsAContradiction) {
  TurnTestInput input = Alike(4, 0.3, 0);
  input.differences[0] = 3;
  EXPECT_FALSE(TestTurns(input, {}).contradicted);
  for (const double sign : {-1.0, 1.0}) {
    input.deviations[0] = 4.9 * sign;
    EXPECT_FALSE(TestTurns(input, {}).contradicted);
    input.deviations[0] = 5.1 * sign;
    EXPECT_TRUE(TestTurns(input, {}).contradicted);
  }
  input.deviations[0] = -18;
  const TurnTest test = TestTurns(input, {});
  EXPECT_TRUE(test.contradicted);
  EXPECT_EQ(test.worst_turn, 0);
}

TEST(TurnTest, WhatIsTooSmallToMatterIsNoContradiction) {
  EXPECT_TRUE(TestTurns(Alike(10, 200, 0.06), {}).contradicted);
  EXPECT_TRUE(TestTurns(Alike(10, 200, -0.06), {}).contradicted);
  const TurnTest small = TestTurns(Alike(10, 200, 0.04), {});
  EXPECT_FALSE(small.contradicted);
  EXPECT_GT(small.inflation, 4) << "sigma grows all the same";
}

TEST(TurnTest, ASlipFarFromItsPriorContradicts) {
  for (const double sign : {1.0, -1.0}) {
    TurnTestInput input = Alike(4, 1);
    input.slip_deviation = 2.4 * sign;
    EXPECT_FALSE(TestTurns(input, {}).contradicted);
    input.slip_deviation = 2.6 * sign;
    EXPECT_TRUE(TestTurns(input, {}).contradicted);
    input.differences.assign(4, 0.01);
    EXPECT_FALSE(TestTurns(input, {}).contradicted) << "it does not matter";
  }
}

TEST(TurnTest, SigmaGrowsWithTheScatterAndNeverShrinks) {
  EXPECT_EQ(TestTurns(Alike(6, 0), {}).inflation, 1);
  EXPECT_EQ(TestTurns(Alike(6, 4), {}).inflation, 1);
  EXPECT_NEAR(TestTurns(Alike(6, 45), {}).inflation, 3, 1e-12);
}

TEST(TurnTest, OneTurnCannotContradictItself) {
  const TurnTest test = TestTurns(Alike(1, 100), {});
  EXPECT_FALSE(test.contradicted);
  EXPECT_EQ(test.inflation, 1);
  EXPECT_EQ(test.degrees_of_freedom, 0);
  const TurnTest none = TestTurns({}, {});
  EXPECT_FALSE(none.contradicted);
  EXPECT_EQ(none.worst_turn, -1);
  EXPECT_EQ(none.disagreement, 0);
}

TEST(TurnTest, NamesTheTurnThatDeviatesMost) {
  TurnTestInput input = Alike(4, 1);
  input.deviations = {1, -0.5, -2, 1.5};
  input.differences = {0.1, -0.02, -0.4, 0.3};
  input.weights = {1, 1, 2, 1};
  const TurnTest test = TestTurns(input, {});
  EXPECT_EQ(test.worst_turn, 2);
  EXPECT_NEAR(test.disagreement, (0.1 + 0.02 + 2 * 0.4 + 0.3) / 5, 1e-12);
}

TEST(TurnTest, RefusesSenselessOptions) {
  const auto refused = [](auto change) { return RefusedField<TurnTestOptions>(change); };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_EQ(refused([](auto& o) { o.min_probability = 0; }), "min_probability");
  EXPECT_EQ(refused([](auto& o) { o.max_prior_deviation = 0; }), "max_prior_deviation");
  EXPECT_EQ(refused([](auto& o) { o.max_turn_deviation = 0; }), "max_turn_deviation");
  EXPECT_EQ(refused([](auto& o) { o.min_disagreement = -1; }), "min_disagreement");
}

TEST(ReductionSignificance, IsStudentsTAsANormalDeviate) {
  const auto deviation = [](double t, int n) { return ReductionSignificance(1 + t * t / n, 1, n); };
  // Two-sided 0.1 %: t with so many degrees of freedom, and the normal deviate.
  for (const auto& [n, t] : {std::pair{5, 6.869}, {10, 4.587}, {30, 3.646}, {1000, 3.300}})
    EXPECT_NEAR(deviation(t, n), 3.291, 0.03) << n;
  EXPECT_EQ(deviation(0, 5), 0);
  EXPECT_EQ(ReductionSignificance(3, 1, 0), 0);
  EXPECT_EQ(ReductionSignificance(1, 2, 5), 0);
}

}  // namespace
}  // namespace turnscale
