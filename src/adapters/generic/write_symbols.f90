!> Writes the C source of libasperity_generic: the symbols that MGIS and MTest read of each behaviour, with names and
!> bounds of the contract, and its functions. The build runs it: write_symbols FILE.
program write_symbols
  use asperity_contract, only: n_statev, prop_table, prop_type, version
  use asperity_generic, only: behaviour_name, material_properties, most_planes, name_length, water_name
  use asperity_kinds, only: wp
  use asperity_rie_law, only: statev_name
  use asperity_text, only: integer_text, to_text
  implicit none
  !> Longest text in a list, longest name of a function.
  integer, parameter :: text_length = 32
  !> What a behaviour may assume of the deformation, with the number of components of a joint and of a layer (0: none).
  character(len=text_length), parameter :: hypotheses(5) = [character(len=text_length) :: "Tridimensional", &
    "PlaneStrain", "Axisymmetrical", "GeneralisedPlaneStrain", "PlaneStress"]
  integer, parameter :: of_joint(5) = [3, 2, 2, 2, 2], of_layer(5) = [6, 4, 4, 4, 0]
  !> Type numbers of MGIS.
  integer, parameter :: scalar = 0, symmetric_tensor = 1, vector = 2
  !> Symbols with the same value in all behaviours. Isotropic (SymmetryType 0) means that the caller rotates strain and
  !> stress to the axes of the joint.
  character(len=*), parameter :: switches(*) = [character(len=52) :: "mfront_mkt = 1", "api_version = 1", &
    "SymmetryType = 0", "ElasticSymmetryType = 0", "requiresStiffnessTensor = 0", &
    "requiresThermalExpansionCoefficientTensor = 0", &
    "UsableInPurelyImplicitResolution = 1", &
    "nInitializeFunctions = 0", "nPostProcessings = 0"]
  character(len=*), parameter :: texts(*) = [character(len=29) :: &
    'tfel_version = "none"', 'src = "asperity"', 'unit_system = ""', 'author = ""', 'date = ""', 'validator = ""']
  !> A joint of Cast3M, which passes the arguments of Abaqus.
  character(len=*), parameter :: castem(*) = [character(len=90) :: &
    "int asperity_castem_joint(int, int, double *, double *, double *, const double *,", &
    "  const double *, const double *, const double *, const double *, const long *,", &
    "  const long *, const double *, const long *, double *);", &
    "#define JOINT(name, n, wet) \", &
    "  void name(double *stress, double *statev, double *ddsdde, void *a, void *b, void *c, \", &
    "    void *d, void *e, void *f, void *g, double *stran, double *dstran, void *h, \", &
    "    double *dtime, void *i, void *j, double *predef, double *dpred, void *m, void *o, \", &
    "    void *p, \", &
    "    long *ntens, long *nstatv, double *props, long *nprops, void *q, void *r, \", &
    "    double *pnewdt, void *s, void *t, void *u, void *v, void *w, void *x, void *y, \", &
    "    void *z, long *kinc) { \", &
    "    (void)a, (void)b, (void)c, (void)d, (void)e, (void)f, (void)g, (void)h, (void)i, \", &
    "    (void)j, (void)m, (void)o, (void)p, (void)q, (void)r, (void)s, \", &
    "    (void)t, (void)u, (void)v, (void)w, (void)x, (void)y, (void)z; \", &
    "    *kinc = asperity_castem_joint(n, wet, stress, statev, ddsdde, stran, dstran, \", &
    "      dtime, predef, dpred, ntens, nstatv, props, nprops, pnewdt); }"]
  character(len=*), parameter :: kinds(3) = [character(len=6) :: "Joint", "Layer", "Castem"]
  character(len=1024) :: path
  integer :: i, n, unit

  call get_command_argument(1, path)
  open (newunit=unit, file=trim(path), action="write", status="replace")
  write (unit, "(a)") "/* Written by write_symbols from the contract of asperity " // version // ". */"
  write (unit, "(a)") "int asperity_generic_joint(void *point, int n_planes, int n, int wet);"
  write (unit, "(a)") "int asperity_generic_layer(void *point, int n_planes, int n, int wet);"
  write (unit, "(a)") (trim(castem(n)), n=1, size(castem))
  do n = 1, most_planes
    do i = 1, size(kinds)
      call write_behaviour(trim(kinds(i)), .false., n)
      call write_behaviour(trim(kinds(i)), .true., n)
    end do
  end do
  close (unit)

contains

  !> All symbols of a behaviour.
  subroutine write_behaviour(kind, wet, n_planes)
    character(len=*), intent(in) :: kind   !! Joint, Layer or Castem
    logical, intent(in) :: wet             !! with water in the joint
    integer, intent(in) :: n_planes        !! number of planes
    character(len=text_length) :: gradient, force, none(0)
    character(len=name_length) :: name
    character(len=:), allocatable :: call_of
    integer :: components(size(hypotheses))
    type(prop_type), allocatable :: properties(:)
    integer :: i, kind_of_gradient
    logical :: layer

    layer = kind == "Layer"
    name = behaviour_name(trim(merge("Wet", "   ", wet)) // kind, n_planes)
    gradient = merge("Strain             ", "OpeningDisplacement", layer)
    force = merge("Stress       ", "CohesiveForce", layer)
    kind_of_gradient = merge(symmetric_tensor, vector, layer)
    components = merge(of_layer, of_joint, layer)
    if (kind == "Castem") components(3) = 0   ! MTest has no such joint

    write (unit, "(/, a)") "/* " // trim(name) // " */"
    do i = 1, size(switches)
      call declare("unsigned short", name, switches(i))
    end do
    call declare("unsigned short", name, "BehaviourType = " // merge("1", "3", layer))
    call declare("unsigned short", name, "BehaviourKinematic = " // merge("1", "2", layer))
    ! Cast3M passes the temperature by an argument of its own
    call declare("unsigned short", name, "TemperatureRemovedFromExternalStateVariables = " // &
      merge("1", "0", kind == "Castem"))
    call declare("unsigned short", name, "ComputesInternalEnergy = " // merge("0", "1", kind == "Castem"))
    call declare("unsigned short", name, "ComputesDissipatedEnergy = " // merge("0", "1", kind == "Castem"))
    call declare("char *const", name, 'mfront_interface = "' // trim(merge("Castem ", "Generic", kind == "Castem")) // &
      '"')
    do i = 1, size(texts)
      call declare("char *const", name, texts(i))
    end do
    call declare("char *const", name, 'build_id = "asperity ' // version // '"')
    call list(name, "ModellingHypotheses", pack(hypotheses, components > 0))
    call list(name, "Gradients", [gradient], kind_of_gradient)
    call list(name, "ThermodynamicForces", [force], kind_of_gradient)
    ! one block: derivative of the first with respect to the second
    call list(name, "TangentOperatorBlocks", [force, gradient])
    call list(name, "InternalStateVariables", [(statev_name(i, n_planes, .true.), i=1, &
      n_statev(n_planes, .true., .true.))], scalar)
    call list(name, "ExternalStateVariables", pack([character(len=text_length) :: water_name], [wet]), scalar)
    call list(name, "Parameters", none, scalar)
    properties = pack(prop_table, material_properties(layer))
    call list(name, "MaterialProperties", properties%name)
    do i = 1, size(properties)
      associate (row => properties(i))
        if (row%lower > -huge(1.0_wp)) call declare("long double", name, trim(row%name) // "_LowerPhysicalBound = " // &
          to_text(row%lower))
        if (row%upper < huge(1.0_wp)) call declare("long double", name, trim(row%name) // "_UpperPhysicalBound = " // &
          to_text(row%upper))
      end associate
    end do
    if (kind == "Castem") then
      write (unit, "(a)") "JOINT(" // trim(name) // ", " // integer_text(n_planes) // ", " // &
        merge("1", "0", wet) // ")"
      return
    end if
    call_of = merge("asperity_generic_layer", "asperity_generic_joint", layer)
    do i = 1, size(hypotheses)
      if (components(i) == 0) cycle
      write (unit, "(a)") "int " // trim(name) // "_" // trim(hypotheses(i)) // "(void *point) { return " // &
        call_of // "(point, " // integer_text(n_planes) // ", " // integer_text(components(i)) // ", " // &
        merge("1", "0", wet) // "); }"
    end do
  end subroutine write_behaviour

  !> A constant of a behaviour with its value.
  subroutine declare(type_of, name, what)
    character(len=*), intent(in) :: type_of, name, what   !! in C; behaviour; symbol = value
    write (unit, "(a)") "const " // type_of // " " // trim(name) // "_" // trim(what) // ";"
  end subroutine declare

  !> A list of texts, its length and, on request, the types of the variables that it names, which are the same for all.
  subroutine list(name, what, values, kind_of)
    character(len=*), intent(in) :: name, what               !! behaviour, symbol
    character(len=*), intent(in) :: values(:)                !! its values
    integer, intent(in), optional :: kind_of                 !! type number of MGIS
    integer :: i
    call declare("unsigned short", name, "n" // what // " = " // integer_text(size(values)))
    write (unit, "(a)") "const char *const " // trim(name) // "_" // what // "[] = {"
    write (unit, "(2x, a)") ('"' // trim(values(i)) // '",', i=1, size(values)), "0};"
    if (.not. present(kind_of)) return
    write (unit, "(*(a))") "const int ", trim(name), "_", what, "Types[] = {", &
      (integer_text(kind_of) // ", ", i=1, size(values)), "0};"
  end subroutine list

end program write_symbols
