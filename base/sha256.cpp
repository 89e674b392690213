#include "base/sha256.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <stdexcept>

namespace kantaro {
namespace {

struct FreeContext {
  void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
};
using ContextPointer = std::unique_ptr<EVP_MD_CTX, FreeContext>;

void Require(int ok) {
  if (ok != 1) throw std::runtime_error("OpenSSL refused a SHA-256 operation");
}

}  // namespace

struct Sha256::Context {
  ContextPointer md{EVP_MD_CTX_new()};
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  Require(EVP_DigestInit_ex(context_->md.get(), EVP_sha256(), nullptr));
}

Sha256::~Sha256() = default;

void Sha256::Add(std::span<const std::byte> bytes) {
  Require(EVP_DigestUpdate(context_->md.get(), bytes.data(), bytes.size()));
}

std::string Sha256::HexDigest() const {
  const ContextPointer copy(EVP_MD_CTX_new());
  Require(EVP_MD_CTX_copy_ex(copy.get(), context_->md.get()));
  std::array<unsigned char, 32> digest{};
  unsigned int length = 0;
  Require(EVP_DigestFinal_ex(copy.get(), digest.data(), &length));
  std::string text;
  for (const unsigned char byte : digest) text += fmt::format("{:02x}", byte);
  return text;
}

}  // namespace kantaro
