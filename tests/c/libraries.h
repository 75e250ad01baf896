/* Symbols of a library that is opened by its path. */
#ifndef LIBRARIES_H
#define LIBRARIES_H
#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#include <stdint.h>
#include <windows.h>
#define RTLD_NOW 0
#define dlopen(path, how) ((void *)LoadLibraryA(path))
#define dlsym(library, name) ((void *)(intptr_t)GetProcAddress(library, name))
#define dlerror() "it cannot be loaded"
#else
#include <dlfcn.h>
#endif
#endif
