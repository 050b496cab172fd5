# A table of the registers that shaders take, from what statistics_layer.c writes: a row for each GPU, a file each.
BEGIN { FS = "\t" }
FNR == 1 {
    name = FILENAME
    sub(".*/", "", name)
    gpus[++count] = name
}
{
    stage = $1 ($2 == "compute" ? "" : "." substr($2, 1, 4))
    if (!(stage in known)) {
        known[stage] = 1
        stages[++columns] = stage
    }
    registers = spilled = 0
    for (i = 4; i <= NF; i++) {
        split($i, pair, "=")
        if (pair[1] == "VGPRs" || pair[1] == "Number of GPRs") registers = pair[2]
        if (pair[1] == "Scratch size" || pair[1] == "SLM Size") spilled = pair[2]
    }
    at = name SUBSEP stage
    if (registers + 0 > most[at]) most[at] = registers + 0
    if (spilled + 0 > spills[at]) spills[at] = spilled + 0
    subgroup[at] = $3
}
END {
    for (j = 1; j <= columns; j++) {
        printf "%-22s", stages[j]
        for (i = 1; i <= count; i++) {
            at = gpus[i] SUBSEP stages[j]
            cell = at in most ? most[at] (spills[at] ? "!" spills[at] : "") "/" subgroup[at] : "-"
            printf " %10s", cell
        }
        printf "\n"
    }
    printf "%-22s", "registers/subgroup"
    for (i = 1; i <= count; i++) printf " %10s", gpus[i]
    printf "\n"
}
