#include "network/swmm_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <utility>

#include "network/check.hpp"

namespace kantaro::network::swmm {
namespace {

/// Headings that are read, by what SWMM tells them by.
constexpr std::array<std::pair<std::string_view, std::string_view>, 14> kRead{
    {{"OPTION", "OPTIONS"},
     {"MAP", "MAP"},
     {"JUNC", "JUNCTIONS"},
     {"OUTF", "OUTFALLS"},
     {"STOR", "STORAGE"},
     {"DIVI", "DIVIDERS"},
     {"COND", "CONDUITS"},
     {"PUMP", "PUMPS"},
     {"ORIF", "ORIFICES"},
     {"WEIR", "WEIRS"},
     {"OUTL", "OUTLETS"},
     {"XSECT", "XSECTIONS"},
     {"COORD", "COORDINATES"},
     {"VERT", "VERTICES"}}};

/// Headings that say nothing about the sewer's shape.
constexpr std::string_view kPassedOver[] = {
    "TITLE",  "FILE",   "RAIN",     "TEMP",    "EVAP",    "SUBC",     "SUBA",    "INFIL",   "AQUIF",
    "GROUND", "SNOW",   "TRANSECT", "LOSS",    "CONTROL", "POLL",     "LANDUSE", "BUILDUP", "WASH",
    "COVER",  "INFLOW", "DWF",      "PATTERN", "RDII",    "HYDRO",    "LOADING", "TREAT",   "CURVE",
    "TIMES",  "REPORT", "POLYGON",  "LABEL",   "SYMBOL",  "BACKDROP", "TAG",     "PROFILE", "LID",
    "GW",     "ADJUST", "EVENT",    "STREET",  "INLET"};

/// Words between blanks, or between double quotes, up to a semicolon.
std::vector<std::string_view> Words(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; at < line.size() && line[at] != ';';) {
    if (std::isspace(static_cast<unsigned char>(line[at])) != 0) {
      ++at;
      continue;
    }
    const bool quoted = line[at] == '"';
    if (quoted) ++at;
    const std::size_t end =
        std::min(line.find_first_of(quoted ? "\"" : " \t\r\f\v;", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = quoted ? std::min(end + 1, line.size()) : end;
  }
  return words;
}

std::string SectionName(std::string_view line, int number, const std::filesystem::path& file) {
  const std::size_t end = line.find(']');
  if (end == std::string_view::npos) {
    throw InputError(file, number, std::string(line.substr(0, 40)),
                     "a section's heading ends with ]: the file may have been cut here");
  }
  return Upper(line.substr(1, end - 1));
}

bool IsAscii(std::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

/// SWMM on Windows writes Latin-1: names are kept as UTF-8.
std::string FromLatin1(std::string_view text) {
  std::string utf8;
  utf8.reserve(text.size());
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x80) {
      utf8 += c;
    } else {
      utf8 += static_cast<char>(0xC0 | (code >> 6));
      utf8 += static_cast<char>(0x80 | (code & 0x3F));
    }
  }
  return utf8;
}

}  // namespace

InputError Row::Error(std::string_view column, const std::string& problem) const {
  return InputError(*file, line, fmt::format("{}.{}", section, column), problem);
}

std::string Row::Word(std::size_t position, std::string_view column) const {
  if (position < words.size()) return std::string(words[position]);
  throw Error(column, fmt::format("the row ends before this column, it has {} of the {} wanted",
                                  words.size(), position + 1));
}

std::string Row::Name(std::size_t position, std::string_view column) const {
  const std::string name = Word(position, column);
  if (name.empty() || name.size() > kLongestName) {
    throw Error(column, fmt::format("a name has from 1 to {} bytes", kLongestName));
  }
  if (std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < 0x20; })) {
    throw Error(column, "a name is made of printable characters");
  }
  return name;
}

double Row::Number(std::size_t position, std::string_view column) const {
  const std::string word = Word(position, column);
  const char* first = word.data() + (word.starts_with('+') ? 1 : 0);
  double value = 0.0;
  const auto [end, error] = std::from_chars(first, word.data() + word.size(), value);
  // Beyond 1e9 in any unit it is no length, and sums of such would overflow.
  if (error != std::errc() || end != word.data() + word.size() || !(std::abs(value) <= 1e9)) {
    throw Error(column, fmt::format("\"{}\" is not a number", word.substr(0, 40)));
  }
  return value;
}

double Row::Positive(std::size_t position, std::string_view column) const {
  const double value = Number(position, column);
  if (value > 0.0) return value;
  throw Error(column, fmt::format("{} must be above 0", value));
}

const std::vector<Row>& Text::Rows(std::string_view section) const {
  static const std::vector<Row> kNone;
  const auto found = sections.find(section);
  return found == sections.end() ? kNone : found->second;
}

std::string Upper(std::string_view word) {
  std::string upper(word);
  std::transform(upper.begin(), upper.end(), upper.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return upper;
}

std::string Quotable(std::string_view text) {
  constexpr std::size_t kMost = 60;
  std::size_t end = std::min(text.size(), kMost);
  while (end < text.size() && end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) {
    --end;  // not in the middle of a character
  }
  std::string quotable(text.substr(0, end));
  std::replace_if(
      quotable.begin(), quotable.end(), [](unsigned char c) { return c < 0x20; }, ' ');
  return quotable;
}

std::string Cleaned(const std::string& text, const std::filesystem::path& file) {
  const auto control = std::find_if(text.begin(), text.end(), [](unsigned char c) {
    return (c < 0x20 && c != '\n' && c != '\r' && c != '\t' && c != '\f' && c != 0x1a) || c == 0x7f;
  });
  if (control != text.end()) {
    throw InputError(file, static_cast<int>(std::count(text.begin(), control, '\n')) + 1, "",
                     "holds a control character, so it is no SWMM text");
  }
  std::string clean = text.starts_with("\xEF\xBB\xBF") ? text.substr(3) : text;
  std::replace(clean.begin(), clean.end(), '\x1a', ' ');  // old DOS programs' end-of-file mark
  if (clean.find('\n') == std::string::npos) std::replace(clean.begin(), clean.end(), '\r', '\n');
  return IsAscii(clean) || IsUtf8(clean) ? clean : FromLatin1(clean);
}

Text Split(std::string_view text, const std::filesystem::path& file) {
  Text split;
  std::string_view section;  // empty: one that is passed over
  bool any = false;
  int number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = text.substr(at, end - at);
    at = end + 1;
    ++number;
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.starts_with('[')) {
      const std::string name = SectionName(line, number, file);
      const auto begins = [&](std::string_view known) { return name.starts_with(known); };
      const auto* const known = std::find_if(kRead.begin(), kRead.end(),
                                             [&](const auto& one) { return begins(one.first); });
      section = known == kRead.end() ? std::string_view() : known->second;
      if (section.empty() && std::none_of(std::begin(kPassedOver), std::end(kPassedOver), begins)) {
        split.unknown.emplace_back(number, Quotable(name));
      }
      any = true;
    } else if (!section.empty()) {
      std::vector<std::string_view> words = Words(line);
      if (!words.empty()) {
        split.sections[std::string(section)].push_back({&file, section, number, std::move(words)});
      }
    } else if (!any && !Words(line).empty()) {
      throw InputError(file, number, "",
                       "this is no SWMM file: it begins before the first [SECTION]");
    }
  }
  return split;
}

}  // namespace kantaro::network::swmm
