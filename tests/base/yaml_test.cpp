#include "base/yaml.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <random>
#include <string>

#include "base/files.hpp"

namespace kantaro {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

YamlNode Parse(const std::string& text) { return YamlNode::Parse(text, "f.yaml"); }

std::string ProblemOf(const auto& action) {
  try {
    (void)action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError was thrown";
}

std::string ProblemOfParsing(const std::string& text) {
  return ProblemOf([&] { return Parse(text); });
}

std::string Repeated(int times, const std::string& part) {
  std::string text;
  for (int i = 0; i < times; ++i) text += part;
  return text;
}

constexpr char kNetwork[] =
    "name: test field\n"
    "wet: true\n"
    "pipes:\n"
    "  - id: P1\n"
    "    diameter_mm: 250\n"
    "  - id: P2\n"
    "    diameter_mm: -300\n"
    "    at_m: [0, +1.5, -2e-1]\n";

TEST(YamlNode, ReadsEveryKindOfValue) {
  const YamlNode root = Parse(kNetwork);
  const YamlNode second = root["pipes"].Elements().at(1);
  EXPECT_EQ(root["name"].Text(), "test field");
  EXPECT_TRUE(root["wet"].Boolean());
  EXPECT_EQ(second["diameter_mm"].Number(), -300.0);
  EXPECT_EQ(second["diameter_mm"].Integer(-300, 0), -300);
  EXPECT_THAT(second["at_m"].Numbers(3), ElementsAre(0.0, 1.5, -0.2));
}

TEST(YamlNode, KeepsTheFilesOrderOfKeys) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : Parse("zulu: 1\nalpha: 2\nmike: 3\n").Entries())
    keys.push_back(key);
  EXPECT_THAT(keys, ElementsAre("zulu", "alpha", "mike"));
}

TEST(YamlNode, KnowsWhereAValueStands) {
  const YamlNode diameter = Parse(kNetwork)["pipes"].Elements().at(1)["diameter_mm"];
  EXPECT_EQ(diameter.line(), 7);
  EXPECT_EQ(diameter.field(), "pipes[1].diameter_mm");
  EXPECT_EQ(ProblemOf([&] { return diameter.Positive(); }),
            "f.yaml:7: pipes[1].diameter_mm: -300 must be above 0");
}

TEST(YamlNode, NamesAMissingKeyAtTheMapThatLacksIt) {
  EXPECT_EQ(ProblemOf([] { return Parse(kNetwork)["pipes"].Elements().at(0)["at_m"]; }),
            "f.yaml:4: pipes[0]: the key \"at_m\" is missing");
  EXPECT_FALSE(Parse(kNetwork).Find("depth").has_value());
}

TEST(YamlNode, NamesAnUnknownKeyAndTheKnownOnes) {
  EXPECT_EQ(ProblemOf([] {
              Parse("name: a\n\ncolour: red\n").AllowOnly({"name", "pipes"});
              return 0;
            }),
            "f.yaml:3: colour: unknown key; known here: name, pipes");
}

TEST(YamlNode, RefusesAKeyThatStandsTwice) {
  EXPECT_EQ(ProblemOf([] { return Parse("a: 1\nb: 2\na: 3\n")["b"]; }),
            "f.yaml:3: a: the key stands here twice");
}

TEST(YamlNode, RefusesValuesOfTheWrongType) {
  const YamlNode root = Parse(
      "word: abc\nlist: [1, 2]\nmap: {a: 1}\nnothing:\nhalf: 0.5\nlong: 99999999999999999999\n");
  EXPECT_EQ(ProblemOf([&] { return root["word"].Number(); }),
            "f.yaml:1: word: \"abc\" is not a number");
  EXPECT_EQ(ProblemOf([&] { return root["list"].Number(); }),
            "f.yaml:2: list: a number is wanted here");
  EXPECT_EQ(ProblemOf([&] { return root["map"].Elements(); }),
            "f.yaml:3: map: a list is wanted here");
  EXPECT_EQ(ProblemOf([&] { return root["list"].Entries(); }),
            "f.yaml:2: list: a map of keys is wanted here");
  EXPECT_EQ(ProblemOf([&] { return root["word"]["a"]; }),
            "f.yaml:1: word: a map of keys is wanted here");
  EXPECT_EQ(ProblemOf([&] { return root["nothing"].Text(); }),
            "f.yaml:4: nothing: a word is wanted here");
  EXPECT_EQ(ProblemOf([&] { return root["half"].Integer(0, 1); }),
            "f.yaml:5: half: \"0.5\" is not a whole number");
  EXPECT_EQ(ProblemOf([&] { return root["long"].Integer(0, 1); }),
            "f.yaml:6: long: \"99999999999999999999\" is not a whole number");
  EXPECT_EQ(ProblemOf([&] { return root["word"].Boolean(); }),
            "f.yaml:1: word: \"abc\" is neither true nor false");
}

TEST(YamlNode, RefusesWhatOnlyLooksLikeANumber) {
  for (const std::string text :
       {"1,5", "0x10", "1.5 m", ".inf", "inf", "nan", "1e999", "+-5", "++5", "+", "--5", "1_000"}) {
    EXPECT_THAT(ProblemOf([&] { return Parse("v: " + text)["v"].Number(); }),
                HasSubstr("is not a number"))
        << text;
  }
}

TEST(YamlNode, RefusesNumbersOutOfRange) {
  const YamlNode root = Parse("slope: 0.2\nseeds: 0\nnull_length_m: 0\n");
  EXPECT_EQ(root["slope"].Number(0.0, 0.2), 0.2);
  EXPECT_EQ(ProblemOf([&] { return root["slope"].Number(0.0, 0.1); }),
            "f.yaml:1: slope: 0.2 is outside 0 to 0.1");
  EXPECT_EQ(ProblemOf([&] { return root["seeds"].Integer(1, 9); }),
            "f.yaml:2: seeds: 0 is outside 1 to 9");
  EXPECT_EQ(ProblemOf([&] { return root["null_length_m"].Positive(); }),
            "f.yaml:3: null_length_m: 0 must be above 0");
}

TEST(YamlNode, CountsTheNumbersOfAVector) {
  EXPECT_EQ(ProblemOf([] { return Parse("at_m: [1, 2]")["at_m"].Numbers(3); }),
            "f.yaml:1: at_m: 3 numbers are wanted here, 2 stand here");
}

TEST(YamlNode, RefusesKeysThatAreNoWords) {
  EXPECT_THAT(ProblemOf([] { return Parse("[1, 2]: a").Entries(); }),
              HasSubstr("keys must be plain words"));
}

// Ten lines of tenfold aliases name ten thousand million leaves.
TEST(YamlNode, RefusesAnAliasBombAtItsFirstAnchor) {
  std::string bomb = "name: bomb\na0: &a0 [lol, lol]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string alias = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" +
            Repeated(9, alias + ", ") + alias + "]\n";
  }
  EXPECT_EQ(ProblemOfParsing(bomb),
            "f.yaml:2: anchors and aliases are not accepted, write the value out");
}

TEST(YamlNode, ReadsSixtyFourLevelsAndRefusesMore) {
  YamlNode node = Parse(Repeated(64, "[") + "1" + Repeated(64, "]"));
  for (int i = 0; i < 64; ++i) node = node.Elements().at(0);
  EXPECT_EQ(node.Number(), 1.0);
  EXPECT_EQ(ProblemOfParsing(Repeated(65, "[") + "1" + Repeated(65, "]")),
            "f.yaml:1: nested deeper than 64 levels");
}

TEST(YamlNode, RefusesEndlessNestingInEveryForm) {
  for (const std::string part : {"[", "{a: ", "- ", "? ", "[{"}) {
    EXPECT_THAT(ProblemOfParsing(Repeated(100'000, part)), StartsWith("f.yaml:1: ")) << part;
  }
}

TEST(YamlNode, NamesTheLineOfASyntaxError) {
  EXPECT_THAT(ProblemOfParsing("name: a\npipes: [1, 2\nwet: }\n"),
              StartsWith("f.yaml:3: not valid YAML: "));
}

TEST(YamlNode, RefusesAnEmptyFile) {
  EXPECT_EQ(ProblemOfParsing(""), "f.yaml: the file is empty");
  EXPECT_EQ(ProblemOfParsing("# only a comment\n"), "f.yaml: the file is empty");
}

TEST(YamlNode, RefusesASecondDocumentInsteadOfIgnoringIt) {
  EXPECT_THAT(ProblemOfParsing("a: 1\n---\nb: 2\n"), HasSubstr("one document is wanted"));
  EXPECT_EQ(Parse("---\na: 1\n...\n")["a"].Number(), 1.0);
}

TEST(YamlNode, RefusesMoreValuesThanMemoryIsMeantFor) {
  EXPECT_THAT(ProblemOfParsing("[" + Repeated(8'100'000, "1,") + "1]"),
              HasSubstr("more than 8000000 values"));
}

TEST(YamlNode, RefusesControlCharactersAndNamesTheLine) {
  EXPECT_EQ(ProblemOfParsing("a: 1\nb: \x1b[31m\n"),
            "f.yaml:2: holds a control character, so it is no YAML text");
}

TEST(YamlNode, RefusesFiftyMegabytesOfNoise) {
  std::mt19937_64 engine(1);
  std::string noise(50'000'000, '\0');
  for (char& byte : noise) byte = static_cast<char>(engine());
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("kantaro_noise_" + std::to_string(getpid()));
  WriteFileAtomically(file, noise);
  EXPECT_THAT(ProblemOf([&] { return YamlNode::Load(file); }),
              HasSubstr("holds a control character"));
  std::filesystem::remove(file);
}

// The same noise without the control characters that would end the reading at once.
TEST(YamlNode, RefusesPrintableNoise) {
  std::mt19937_64 engine(1);
  std::string noise(5'000'000, '\0');
  for (char& byte : noise) byte = static_cast<char>(0x20 + engine() % 0xe0);
  EXPECT_THAT(ProblemOfParsing(noise), StartsWith("f.yaml:1: "));
}

}  // namespace
}  // namespace kantaro
