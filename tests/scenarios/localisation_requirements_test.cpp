#include "scenarios/experiments/localisation_requirements.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;

Json Row(const char* set, const char* condition, double within_2cm, double within_5cm,
         double in_stated) {
  return {{"method", "ours"},
          {"landmark", "all"},
          {"set", set},
          {"condition", condition},
          {"within_2cm", within_2cm},
          {"within_5cm", within_5cm},
          {"in_stated_interval", in_stated}};
}

/// All of it, reached by a hair.
Json Reached() {
  return {Row("reproduction", "all", 0.9, 0.99, 0.98), Row("stress", "all", 0.9, 0.97, 0.90),
          Row("reproduction", "up to 1.0 m", 0.95, 1.0, 0.5),
          Row("stress", "up to 1.0 m", 0.95, 1.0, 0.5)};
}

TEST(LocalisationRequirements, AreMetAtTheirLimits) {
  EXPECT_TRUE(MeetsRequirements(Reached()));
  EXPECT_THAT(RequirementsText(Reached()),
              HasSubstr("stress, all: `within_5cm` 97 to 100 %: 97.0 %, met"));
}

TEST(LocalisationRequirements, AreNotMetByLessNorByIntervalsThatHoldTooMuch) {
  for (const auto& [row, key, value] :
       {std::tuple(0, "within_5cm", 0.989), std::tuple(1, "within_5cm", 0.969),
        std::tuple(2, "within_2cm", 0.949), std::tuple(3, "within_2cm", 0.949),
        std::tuple(0, "in_stated_interval", 0.981), std::tuple(1, "in_stated_interval", 0.899)}) {
    Json rows = Reached();
    rows[row][key] = value;
    EXPECT_FALSE(MeetsRequirements(rows)) << row << key;
    EXPECT_TRUE(FailsRequirement(rows[row])) << row << key;
    EXPECT_THAT(RequirementsText(rows), HasSubstr("**not met**"));
  }
}

TEST(LocalisationRequirements, AreNotMetByWhatNoRowTells) {
  for (std::size_t i = 0; i < Reached().size(); ++i) {
    Json rows = Reached();
    rows.erase(i);
    EXPECT_FALSE(MeetsRequirements(rows)) << i;
  }
}

TEST(LocalisationRequirements, AskNothingOfTheThesis) {
  Json row = Row("stress", "all", 0.0, 0.0, 0.0);
  row["method"] = "thesis";
  EXPECT_FALSE(FailsRequirement(row));
  EXPECT_EQ(RequirementsText(Json::array({row})), "");
}

}  // namespace
}  // namespace kantaro::scenarios
