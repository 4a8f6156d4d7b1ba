// The survey's tables of model sizes, and the sizes of the problems that are built.
#include "cpu_reference/oracle/models/model_size.hpp"

#include <gtest/gtest.h>

#include "cpu_reference/oracle/models/friction_pyramid.hpp"
#include "tests/oracle/multibodies.hpp"

namespace lockstep::oracle::models::model_size_test {
namespace {

TEST(ModelSizes, AreThoseOfTheTables) {
  const ModelSizes m = model_sizes({.bodies = 10, .touching_bodies = 3, .joints = 4, .contacts = 20, .directions = 6});
  EXPECT_EQ(m.dncp, 7u * 4 + 4 * 20 + 13 * 10);
  EXPECT_EQ(m.mncp, m.dncp);
  EXPECT_EQ(m.mlcp, 8u * 4 + (2 + 6) * 20 + 6 * 10);
  EXPECT_EQ(m.lcp, 3u * 4 + (2 + 6) * 20);
  EXPECT_EQ(m.dca_mlcp1, (2u + 6) * 20 + 12 + 6 * 3 + 3 * 4);
  EXPECT_EQ(m.dca_mlcp2, (2u + 6) * 20 + 12 + 3 * 4);
  EXPECT_EQ(m.dca_lcp, (2u + 6) * 20 + 3 * 4);
}

TEST(ModelSizes, AreThoseOfTheProblemsThatAreBuilt) {
  const Multibody m = test::hinged_bar(0.4, 0.3);
  for (const int directions : {4, 8, 16}) {
    const ModelSizes sizes = model_sizes({.bodies = 2,
                                          .touching_bodies = 2,
                                          .joints = 1,
                                          .contacts = m.contacts.size(),
                                          .directions = std::size_t(directions)});
    const FrictionPyramid pyramid(m, directions);
    EXPECT_EQ(Index(sizes.mlcp), pyramid.mixed().stacked().size());
    EXPECT_EQ(Index(sizes.lcp), pyramid.reduced().size());
  }
}

}  // namespace
}  // namespace lockstep::oracle::models::model_size_test
