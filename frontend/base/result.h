#pragma once
#include <string>
#include <utility>
#include <variant>

namespace tagtwist {

/// Why bad input was refused; one line, written for the person who typed it:
/// "configs/x.yaml:12: estimator.window_frames: expected >= 2, got -3".
struct Error {
  std::string message;
};

/// A value, or why there is none.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : v_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : v_(std::move(error)) {}  // NOLINT(google-explicit-constructor)
  explicit operator bool() const { return v_.index() == 0; }
  const T& operator*() const { return std::get<0>(v_); }
  T& operator*() { return std::get<0>(v_); }
  const T* operator->() const { return &std::get<0>(v_); }
  T* operator->() { return &std::get<0>(v_); }
  const Error& error() const { return std::get<1>(v_); }

 private:
  std::variant<T, Error> v_;
};

/// Success, or why not: `return Ok();` or `return Error{...};`.
using Status = Result<std::monostate>;
inline Status Ok() { return std::monostate{}; }

}  // namespace tagtwist
