# CHANGELOG.md in the format of Debian's changelogs, lines of at most 80 characters:
#   awk -f changelog.awk -v package=NAME -v version=V -v maintainer="NAME <MAIL>" -v date=RFC-5322 CHANGELOG.md
# "## Unreleased" is the version and the date that are given; "## 1.2.0 - ..." would be 1.2.0 and the same date.

# The item that was read, wrapped.
function print_item(    words, count, line, i) {
  count = split(item, words, " ")
  line = "  *"
  for (i = 1; i <= count; ++i) {
    if (line != "  *" && line != "   " && length(line) + 1 + length(words[i]) > 80) {
      print line
      line = "   "
    }
    line = line " " words[i]
  }
  if (count > 0) print line
  item = ""
}

function print_end() {
  print_item()
  if (open) printf "\n -- %s  %s\n", maintainer, date
  open = 0
}

/^## / {
  if (open) { print_end(); print "" }
  printf "%s (%s) unstable; urgency=medium\n", package, $2 == "Unreleased" ? version : $2
  open = 1
  next
}
!open { next }
/^### / { print_item(); printf "\n  [ %s ]\n", substr($0, 5); next }
/^- / { print_item(); item = substr($0, 3); next }
/^ / { item = item " " $0 }
END { print_end() }
