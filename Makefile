# Thin: each target is what one would type. On a fresh Debian 12 `make demo` and `make test` bring
# everything they need (root or sudo).
.PHONY: setup build demo test fuzz install package docs format lint clean
JOBS := $(shell nproc)
# One more than cores: some tests wait, for a page or a clock, most of their time.
TEST_JOBS := $(shell expr $(JOBS) + 1)
PREFIX ?= /usr/local
# Several sources of a folder as one unit: whole builds take less. OFF for work on a file in the same build.
UNITY ?= ON
CONFIGURE := cmake --log-level=WARNING -DTAGTWIST_UNITY=$(UNITY)

setup:
	@scripts/setup

# The programs, in build/release/apps/.
build: setup
	@$(CONFIGURE) --preset release
	@cmake --build --preset release --target programs --parallel $(JOBS)

# Renders a flight over the course's mat, estimates it, and names the report to open.
demo: build
	@scripts/demo

# Every test in release, and then all but the slow and real-data ones under the address and
# undefined-behaviour sanitizers. With ROS bags, and the report in a real browser. --fresh: where a folder changes its
# compiler, CMake forgets all else that it is given, the sanitizers too.
test: setup
	@scripts/setup test
	@scripts/setup rosbag
	@scripts/setup lint
	@$(CONFIGURE) --preset release
	@cmake --build --preset release --parallel $(JOBS)
	@ctest --preset release --parallel $(TEST_JOBS)
	@$(CONFIGURE) --fresh --preset debug
	@cmake --build --preset debug --parallel $(JOBS)
	@ctest --preset debug --parallel $(TEST_JOBS)

# One reader, or the estimator, over inputs that clang's libFuzzer finds: make fuzz FUZZ=yaml SECONDS=60
# (tests/fuzz/README.md).
SECONDS ?= 60
fuzz: setup
	@scripts/setup fuzz
	@scripts/setup rosbag
	@cmake --preset fuzz --log-level=WARNING
	@cmake --build build/fuzz --target tagtwist_fuzz --parallel $(JOBS)
	@scripts/fuzz "$(FUZZ)" "$(SECONDS)"

# Programs, libraries, headers, and the Python module where it is built; `make install PREFIX=DIR` elsewhere than in /usr/local.
install: build
	@cmake --build --preset release --target python --parallel $(JOBS)
	@cmake --install build/release --prefix "$(PREFIX)"

# Debian packages in build/release.
package: build
	@cmake --build --preset release --target python --parallel $(JOBS)
	@cd build/release && cpack

# Reference of the libraries: build/release/docs/html/index.html.
docs:
	@scripts/setup
	@scripts/setup docs
	@$(CONFIGURE) --preset release
	@cmake --build build/release --target docs

format:
	@scripts/setup lint
	@scripts/format

lint: build
	@scripts/setup lint
	@scripts/format --check
	@scripts/lint

clean:
	rm -rf build results
