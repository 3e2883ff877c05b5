#pragma once

// TAGTWIST_SANITIZED: under the address or the thread sanitizer, which replace malloc and hold back
// what is freed. gcc tells it by macros, clang by features.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TAGTWIST_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define TAGTWIST_SANITIZED
#endif
#endif
