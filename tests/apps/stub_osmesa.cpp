// Stands in for libOSMesa where a test wants one that does not work. STUB_OSMESA says how:
// `no_context` or `no_functions`.

#include <cstdlib>
#include <string_view>

namespace {
bool Lacks(std::string_view what) {
  const char* told = std::getenv("STUB_OSMESA");
  return told != nullptr && told == what;
}
int some_context;
}  // namespace

extern "C" {
void* OSMesaCreateContextExt(unsigned, int, int, int, void*);
void OSMesaDestroyContext(void*);
unsigned char OSMesaMakeCurrent(void*, void*, unsigned, int, int);
void* OSMesaGetProcAddress(const char*);

void* OSMesaCreateContextExt(unsigned, int, int, int, void*) {
  return Lacks("no_context") ? nullptr : &some_context;
}
void OSMesaDestroyContext(void*) {}
unsigned char OSMesaMakeCurrent(void*, void*, unsigned, int, int) { return 1; }
void* OSMesaGetProcAddress(const char*) { return nullptr; }
}
