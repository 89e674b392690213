#include "base/sha256.hpp"

#include <gtest/gtest.h>

#include <string_view>

namespace kantaro {
namespace {

void AddText(Sha256& hash, std::string_view text) { hash.Add(std::as_bytes(std::span(text))); }

// The vectors are those of FIPS 180-4's examples (NIST, "SHA256.pdf") and of the empty message.
TEST(Sha256, GivesTheDigestOfTheEmptyMessage) {
  EXPECT_EQ(Sha256().HexDigest(),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(Sha256, GivesTheDigestOfAbc) {
  Sha256 hash;
  AddText(hash, "abc");
  EXPECT_EQ(hash.HexDigest(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Sha256, GivesTheDigestOfTheTwoBlockMessage) {
  Sha256 hash;
  AddText(hash, "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq");
  EXPECT_EQ(hash.HexDigest(), "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256, GoesOnAfterADigestWasTaken) {
  Sha256 hash;
  AddText(hash, "a");
  (void)hash.HexDigest();
  AddText(hash, "bc");
  EXPECT_EQ(hash.HexDigest(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

}  // namespace
}  // namespace kantaro
