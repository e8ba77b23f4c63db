#!/usr/bin/env bash
# Writes the manual pages: one of each program and one of each command of shearwater, from the options that the
# programs themselves know (--dump-options, proto/option_text.h).
#   deploy/man.sh BUILD_DIR OUT_DIR
set -euo pipefail
build=${1:?usage: deploy/man.sh BUILD_DIR OUT_DIR}
out=${2:?usage: deploy/man.sh BUILD_DIR OUT_DIR}
mkdir -p "$out"
version=$("$build/shearwater" --version | sed 's/+.*//')

# pages PROGRAM ABOUT: its records on standard input, its pages in $out.
pages() {
    awk -F '\t' -v out="$out" -v program="$1" -v about="$2" -v version="$version" '
    # Text as roff has it, every sign as it is.
    function roff(text) {
        gsub(/\\/, "\\e", text); gsub(/-/, "\\-", text)
        gsub(/~/, "\\(ti", text); gsub(/`/, "\\(ga", text); gsub(quote, "\\(aq", text)
        return text ~ /^\./ ? "\\&" text : text
    }
    # "HOST:PORT" in italics; of "a|b" the words in bold.
    function value(text,    words, count, i, all) {
        if (text !~ /\|/) return "\\fI" roff(text) "\\fR"
        count = split(text, words, "|")
        for (i = 1; i <= count; i++) all = all (i > 1 ? "|" : "") "\\fB" roff(words[i]) "\\fR"
        return all
    }
    function heading(name) { if (section != name) print ".SH " name > page; section = name }
    function begin(name, text) {
        if (page) close(page)
        page = out "/" name ".1"; section = ""
        print ".TH \"" roff(toupper(name)) "\" 1 \"\" \"" roff(version) "\" \"Shearwater\"" > page
        heading("NAME")
        print roff(name) " \\- " roff(text) > page
    }
    BEGIN { quote = sprintf("%c", 39); if (about) begin(program, about) }
    $1 == "command" { begin(program "-" $2, $3) }
    $1 == "usage"   { heading("SYNOPSIS")
                      if (used == page) print ".br" > page
                      used = page; print ".B " roff($2) > page }
    $1 == "summary" { heading("DESCRIPTION"); print roff($2) > page }
    $1 == "option"  { heading("OPTIONS"); print ".TP" > page
                      print ($2 ? "\\fB" roff($2) "\\fR, " : "") "\\fB" roff($3) "\\fR" ($4 ? " " value($4) : "") > page
                      print roff($5) > page }
    $1 == "note"    { heading("NOTES"); print (noted == page ? ".PP\n" : "") roff($2) > page; noted = page }
    END { if (page) close(page) }'
}

"$build/shearwater" --dump-options | pages shearwater ""
"$build/shearwater-worker" --dump-options | pages shearwater-worker "trace tiles for a Shearwater coordinator"
"$build/shearwater-import" --dump-options | pages shearwater-import "turn a scene file into a scene blob"

# The page of the program itself.
"$build/shearwater" --dump-options | awk -F '\t' -v version="$version" '
    function roff(text) { gsub(/-/, "\\-", text); return text }
    BEGIN {
        print ".TH SHEARWATER 1 \"\" \"" roff(version) "\" \"Shearwater\"\n.SH NAME"
        print "shearwater \\- render scenes with few samples per pixel, on one machine or many"
        print ".SH SYNOPSIS\n.B shearwater\n.I COMMAND\n[options]\n.SH DESCRIPTION"
        print "A coordinator takes jobs over HTTP, workers trace samples, and filters make pictures of them."
        print "Each command has a page of its own, and \\fB\\-\\-help\\fR.\n.SH COMMANDS"
    }
    $1 == "command" { print ".TP\n.BR shearwater\\-" roff($2) " (1)\n" roff($3); also = also ",\n.BR shearwater\\-" roff($2) " (1)" }
    END {
        print ".SH OPTIONS\n.TP\n\\fB\\-\\-help\\fR\nprint the commands\n.TP\n\\fB\\-\\-version\\fR\nprint the build"
        print ".SH ENVIRONMENT"
        print ".TP\n.B SHEARWATER_SERVER\nthe coordinator that commands talk to (default: http://127.0.0.1:8040)"
        print ".TP\n.BR SHEARWATER_TOKEN \", \" SHEARWATER_TOKEN_FILE\nthe access token, or a file with it"
        print ".TP\n.B SHEARWATER_CA\na file with the certificate authorities that are trusted"
        print ".TP\n.B SHEARWATER_ISA\na smaller instruction set than the best of this machine: avx2 or sse4.2"
        print ".SH EXIT STATUS\n0 done, 1 failed, 2 wrong use, 128 + N ended by signal N."
        print ".SH SEE ALSO\n.BR shearwater\\-worker (1),\n.BR shearwater\\-import (1)" also
        print ".PP\nMore documentation is in share/doc/shearwater."
    }' >"$out/shearwater.1"
