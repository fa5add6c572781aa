// Destroys static objects when a master unloads the library. Usually the compiler's start-up files do that; Zig, which
// makes the released binaries, links none, so that it would happen at the end of the process, when the code is gone.
#ifdef __ELF__

// NOLINTBEGIN(bugprone-reserved-identifier): names of the C++ ABI
extern "C" {
extern void* __dso_handle __attribute__((visibility("hidden")));
void __cxa_finalize(void* library);
}
// NOLINTEND(bugprone-reserved-identifier)

namespace {

__attribute__((destructor)) void destroy_statics() { __cxa_finalize(static_cast<void*>(&__dso_handle)); }

}  // namespace

#endif
