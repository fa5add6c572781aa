/* Libraries that are loaded while a program runs, on Windows and elsewhere. */
#pragma once

#ifdef _WIN32
#include <windows.h>
static void* symbol(void* library, const char* name) { return (void*)GetProcAddress(library, name); }
static void* open_library(const char* path) { return LoadLibraryA(path); }
static int close_library(void* library) { return FreeLibrary(library); }
#else
#include <dlfcn.h>
static void* symbol(void* library, const char* name) { return dlsym(library, name); }
static void* open_library(const char* path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static int close_library(void* library) { return dlclose(library) == 0; }
#endif
