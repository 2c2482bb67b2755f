#!/bin/sh
# Doxygen sees the comment that begins a header as the documentation of the file, and what is indented there as it stands.
# Line numbers stay. A class that derives from another specialisation of itself is more than Doxygen can follow.
exec awk '
  { line[NR] = $0 }
  END {
    for (last = 2; last < NR && line[last + 1] ~ /^\/\//; ++last);
    for (n = 1; n <= NR; ++n) {
      text = line[n]
      if (n == 1 && text == "#pragma once") text = "/// @file"
      else if (n <= last && text ~ /^\/\/   /)
        text = "///" (line[n - 1] ~ /^\/\/   / ? "" : " @verbatim ") substr(text, 3) \
          (n < last && line[n + 1] ~ /^\/\/   / ? "" : " @endverbatim")
      else if (n <= last) sub(/^\/\//, "///", text)
      sub(/^struct State : State<Real, 0> {/, "struct State {", text)
      print text
    }
  }' "$1"
