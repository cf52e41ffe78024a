# What the modes of test/run share: the parts with their times, the list of problems, the summary
# line. bash sources this file in the root of the source tree.

problems=() failing_output=""
passed=0 failed=0 skipped=0
part="" part_start=0 part_times=()

# Other Pythons lack the modules of Debian's ROS. A ROS that was sourced has put its own first.
[ "${ROS_DISTRO:-Debian}" != Debian ] || export PATH=/usr/bin:/bin:$PATH
unset ROS_MASTER_URI ROS_HOSTNAME ROS_IP

# say TITLE: ends the part of the run before, whose time it notes, and begins another one.
say() {
  [ -z "$part" ] || part_times+=("$(printf '%6d s  %s' $((SECONDS - part_start)) "$part")")
  part=$* part_start=$SECONDS
  printf '\n== %s\n' "$*"
}

# last_lines LOG: the ends of what the first three failed tests printed, from ctest's log.
last_lines() {
  awk '/ Testing: /{name = $3} /^Output:$/{n = 0} {line[++n] = $0} /^<end of output>$/{end = n}
    /^Test Failed\.$/ && ++failed <= 3{
      print "\n-- " name " ended with"
      for (i = (end > 28 ? end - 25 : 3); i < end; ++i) print line[i]
    }' "$1"
}

# Prints the ends of what failed, the times, the problems and the counts, and ends the run: with 0
# if there is no problem, else with 1. The counts are the last line.
finish() {
  say "Result"
  [ -z "$failing_output" ] || printf '%s\n\n' "$failing_output"
  printf '%s\n' "${part_times[@]}" "$(printf '%6d s  in all' $SECONDS)"
  for problem in "${problems[@]}"; do echo "FAILED: $problem"; done
  echo "$passed passed, $failed failed, $skipped skipped"
  [ ${#problems[@]} -eq 0 ]
  exit
}

# must PROBLEM COMMAND...: ends the run if the command fails, for nothing later makes sense then.
must() {
  local problem=$1
  shift
  if ! "$@"; then
    problems+=("$problem")
    finish
  fi
}

# install_packages SECTION...: installs what is missing, and sets how CMake builds: with all cores,
# and with ninja where it is there. keep_going holds what makes the build go on after an error.
install_packages() {
  say "Packages"
  must "packages could not be installed" config/install_packages "$@"
  export CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}
  keep_going=(-k)
  if command -v ninja >/dev/null; then
    export CMAKE_GENERATOR=${CMAKE_GENERATOR:-Ninja}
    [ "$CMAKE_GENERATOR" != Ninja ] || keep_going=(-k 0)
  fi
}

# add_counts LOG: adds the counts of the summary line that ends the log. Fails if there is none.
add_counts() {
  [[ $(tail -n 1 "$1") =~ ^([0-9]+)\ passed,\ ([0-9]+)\ failed,\ ([0-9]+)\ skipped$ ]] || return 1
  passed=$((passed + BASH_REMATCH[1])) failed=$((failed + BASH_REMATCH[2]))
  skipped=$((skipped + BASH_REMATCH[3]))
}

# add_tests BUILD [ARGS of ctest...]: as run_tests, for a further build of the same run.
add_tests() {
  local counts=("$passed" "$failed" "$skipped")
  run_tests "$@"
  passed=$((passed + counts[0])) failed=$((failed + counts[1])) skipped=$((skipped + counts[2]))
}

# run_tests BUILD [ARGS of ctest...]: runs tests, two more at a time than there are cores, because
# rostests mostly wait. A skipped test is a problem where the test data are there.
run_tests() {
  local build=$1 log=$1/ctest.log total code inner
  shift
  say "Tests"
  export ROS_HOME=$build/ros_home
  rm -rf "$log" "$build/Testing" "$build/test_results"
  (cd "$build" && ctest --output-on-failure -j $(($(nproc) + 2)) "$@") | tee "$log"
  code=${PIPESTATUS[0]}
  # The last lines count tests: older CMakes write no report of use. Without them nothing ran.
  read -r failed total < <(sed -En \
    's/^[0-9]+% tests passed, ([0-9]+) tests? failed out of ([0-9]+)$/\1 \2/p' "$log" | tail -1)
  skipped=$(sed -n '/^The following tests did not run:$/,$p' "$log" | grep -c ' (Skipped)$')
  total=${total:-0} failed=${failed:-0}
  passed=$((total - failed - skipped))
  # The results of rostests say whether a test within was skipped.
  inner=$(grep -rlE '<skipped|\[  SKIPPED \]' "$build/test_results" 2>/dev/null)
  if [ $code -ne 0 ]; then
    problems+=("ctest: $failed of $total tests failed")
    failing_output+=$(last_lines "$build/Testing/Temporary/LastTest.log")
  fi
  [ "$total" -gt 0 ] || problems+=("no test ran")
  if [ -d "${DCM_TEST_DATA:-$PWD/../shared/data}" ]; then
    [ "$skipped" -eq 0 ] ||
      problems+=("$skipped tests were skipped, although the test data are there")
    [ -z "$inner" ] || problems+=("skipped within: $inner")
  else
    echo "The test data are not there: tests that need them were SKIPPED."
  fi
}
