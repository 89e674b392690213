#include "base/input_error.hpp"

#include <gtest/gtest.h>

namespace kantaro {
namespace {

TEST(InputError, NamesFileLineFieldAndProblemInThatOrder) {
  const InputError error("field.yaml", 12, "pipes[3].diameter_mm", "-250 must be above 0");
  EXPECT_STREQ(error.what(), "field.yaml:12: pipes[3].diameter_mm: -250 must be above 0");
  EXPECT_EQ(error.field(), "pipes[3].diameter_mm");
  EXPECT_EQ(error.line(), 12);
}

TEST(InputError, LeavesOutWhatIsNotKnown) {
  EXPECT_STREQ(InputError("field.yaml", {}, "", "no such file").what(), "field.yaml: no such file");
  EXPECT_STREQ(InputError("--seed", {}, "", "\"x\" is not a whole number").what(),
               "--seed: \"x\" is not a whole number");
  EXPECT_STREQ(InputError("", {}, "", "nothing to do").what(), "nothing to do");
  EXPECT_STREQ(InputError("", 3, "", "cut off").what(), "line 3: cut off");
}

}  // namespace
}  // namespace kantaro
