#pragma once
#include <gtest/gtest.h>

#include <string>

#include "estimator/online/config.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal {

/// A configuration with this text, as x.yaml.
inline Result<Config> ConfigOfText(const TempFolder& folder, const std::string& text) {
  WriteText(folder / "x.yaml", text);
  return LoadConfig(folder / "x.yaml");
}
inline Result<Config> ConfigOfText(const std::string& text) {
  return ConfigOfText(TempFolder(), text);
}

/// Its message, without the folder: "x.yaml:2: ..."; "accepted" where it has none.
inline std::string FaultOfText(const std::string& text) {
  const TempFolder folder;
  const auto config = ConfigOfText(folder, text);
  if (config) return "accepted";
  const std::string& message = config.error().message;
  const std::string prefix = folder / "";
  EXPECT_EQ(message.substr(0, prefix.size()), prefix);
  EXPECT_EQ(message.find('\n'), std::string::npos);
  return message.substr(prefix.size());
}

}  // namespace tagtwist::internal
