/* Quoin contact-law ABI: versions, status codes and text buffers.
 * C99 and C++11 or later; no dependency but <stdint.h>.
 *
 * Rules that hold for every header of this folder (a change that breaks one is a new major version):
 *   - every struct that crosses the boundary begins with its size in bytes, set by whoever allocates it;
 *     fields are only ever appended, and a reader never touches a field beyond the size it was given (the column
 *     types of batch.h have no size: they are embedded by value and never change within a major version);
 *   - whoever reads a struct refuses (QUOIN_ERROR_ARGUMENT, or null from quoin_library_v1) one that is shorter than
 *     version 1.0's; a quoin_text that is too short is treated as null;
 *   - fixed-width integers and double only: no enum, bool, long, bit-field or C++ type in a layout;
 *   - no exception, longjmp, signal, stdio or change of floating-point mode crosses the boundary;
 *   - SI units (m, Pa, Pa/m, J/m2); degrees only for properties whose unit says "deg".
 * Tags on functions: [thread-safe] any thread, any time; [material lifetime] until destroy_material. */
#ifndef QUOIN_BASE_H
#define QUOIN_BASE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Major: layouts or meanings changed; minor: something was appended. Hosts and laws work together when the
 * majors agree; each side uses only what the smaller minor knows. */
#define QUOIN_ABI_MAJOR 1u
#define QUOIN_ABI_MINOR 1u

#if defined(_WIN32)
#define QUOIN_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define QUOIN_EXPORT __attribute__((visibility("default")))
#else
#define QUOIN_EXPORT
#endif

typedef int32_t quoin_status;
#define QUOIN_OK ((quoin_status)0)
#define QUOIN_ERROR_ARGUMENT ((quoin_status)1)    /* the caller broke the contract: null, short struct, stride */
#define QUOIN_ERROR_PROPERTY ((quoin_status)2)    /* property values refused; the text lists every fault */
#define QUOIN_ERROR_VERSION ((quoin_status)3)     /* no common ABI version, or a foreign state schema */
#define QUOIN_ERROR_UNSUPPORTED ((quoin_status)4) /* this law does not offer what was asked */
#define QUOIN_ERROR_MEMORY ((quoin_status)5)
#define QUOIN_ERROR_INTERNAL ((quoin_status)6) /* a fault inside the law, caught at the boundary */

/* Caller-owned text buffer. A law writes at most capacity bytes including the final zero, cutting the message if it
 * must, and sets length to the bytes that the whole message takes without the zero. A null quoin_text, or null
 * data with capacity 0, is allowed everywhere and means that no text is wanted (length is set all the same when there
 * is a quoin_text). A function that has nothing to say sets length 0 and, if capacity > 0, data[0] = 0. */
typedef struct quoin_text {
  uint64_t struct_size;
  char* data;
  uint64_t capacity;
  uint64_t length;
} quoin_text;

#ifdef __cplusplus
}
#endif
#endif
