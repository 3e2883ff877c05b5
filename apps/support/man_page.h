#pragma once
#include <string>

#include "apps/support/help_text.h"

namespace tagtwist::internal {

/// What --help says as a man page (man(7), section 1).
std::string ManPage(const Usage& usage, const std::string& version);

}  // namespace tagtwist::internal
