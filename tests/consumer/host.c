/* A host in a separate project: it needs the headers and one library. Prints the law's id. */
#include <quoin/layout_asserts.h>
#include <stdio.h>

#if defined(WITH_DLOPEN)
#include <dlfcn.h>
#include <string.h>
#endif

int main(int argc, char** argv) {
#if defined(WITH_DLOPEN)
  const quoin_host_info me = {sizeof me, QUOIN_ABI_MAJOR, QUOIN_ABI_MINOR, "consumer", "1"};
  void* handle = argc > 1 ? dlopen(argv[1], RTLD_NOW | RTLD_LOCAL) : NULL;
  void* symbol = handle != NULL ? dlsym(handle, QUOIN_LIBRARY_SYMBOL) : NULL;
  quoin_library_function entry;
  const quoin_library* library;
  if (symbol == NULL) return 1;
  memcpy(&entry, &symbol, sizeof entry);
  library = entry(&me, NULL);
  if (library == NULL) return 1;
  printf("%s %s\n", library->laws[0]->id, library->version);
#else
  printf("ABI %u.%u, %d %s\n", QUOIN_ABI_MAJOR, QUOIN_ABI_MINOR, argc, argv[0]);
#endif
  return 0;
}
