/* run_describe LIBRARY MECHANISM: prints what the library `describe` tells of a mechanism, a file of JSON without modal
 * data. C, which needs no library but the system's. */
#include <stdio.h>
#include <stdlib.h>

#include "dynamic_library.h"

typedef char* Describe(const char* mechanism, const char* resources);
typedef void Free(char* text);

static char* content(const char* path) {
  FILE* file = fopen(path, "rb");
  if (!file) return NULL;
  fseek(file, 0, SEEK_END);
  const long size = ftell(file);
  rewind(file);
  char* text = calloc((size_t)size + 1, 1);
  if (text && fread(text, 1, (size_t)size, file) != (size_t)size) text[0] = 0;
  fclose(file);
  return text;
}

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  void* library = open_library(argv[1]);
  char* mechanism = content(argv[2]);
  if (!library || !mechanism) {
    fprintf(stderr, "cannot load %s\n", library ? argv[2] : argv[1]);
    return 1;
  }
  Describe* describe = (Describe*)symbol(library, "sigmafmu_describe");
  Free* release = (Free*)symbol(library, "sigmafmu_free");
  char* told = describe(mechanism, ".");
  if (!told) return 1;
  puts(told);
  release(told);
  free(mechanism);
  return close_library(library) ? 0 : 1;
}
