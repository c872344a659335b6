#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# version.sh PROGRAM SOURCE VERSION: what --version prints, and that an archive of git tells its commit, too. Skipped (77)
# where SOURCE is no checkout of git.
set -uo pipefail

program=$1 source=$2 version=$3 failed=0
fail() { echo "$*"; failed=1; }

said=$("$program" --version)
[[ $said =~ ^turnscale\ ${version//./\\.}(\ \([A-Za-z0-9._+-]+\))?$ ]] || fail "--version: '$said'"
grep -q "^## $version (" "$source/CHANGELOG.md" || fail "CHANGELOG.md lacks $version"

commit=$(git -C "$source" rev-parse --short=7 HEAD 2>/dev/null) || exit $((failed ? 1 : 77))
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
write() { cmake -DSOURCE="$1" -DOUTPUT="$folder/commit.cpp" -P "$source/cmake/WriteCommit.cmake"; }

write "$source"
grep -q "$commit" "$folder/commit.cpp" || fail "not the commit of the checkout: $(<"$folder/commit.cpp")"
time=$(stat -c %y "$folder/commit.cpp")
write "$source"
[[ $(stat -c %y "$folder/commit.cpp") == "$time" ]] || fail "the same commit was written again"

if git -C "$source" cat-file -e HEAD:cmake/archived_commit.txt 2>/dev/null; then
  mkdir "$folder/archive"
  git -C "$source" archive HEAD cmake .gitattributes | tar -x -C "$folder/archive"
  write "$folder/archive"
  # An archive of a tagged commit has the name of the tag alone.
  tag=$(git -C "$source" describe --tags --exact-match 2>/dev/null) || tag=$commit
  grep -qe "$commit" -e "\"$tag\"" "$folder/commit.cpp" || fail "not the commit of the archive: $(<"$folder/commit.cpp")"
fi

mkdir -p "$folder/plain/cmake"
cp "$source/cmake/archived_commit.txt" "$folder/plain/cmake"
write "$folder/plain"
grep -q 'return "";' "$folder/commit.cpp" || fail "a commit of nothing: $(<"$folder/commit.cpp")"
exit $failed
