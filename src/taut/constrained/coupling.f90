!> Which velocities' equations depend on which velocities and coordinates, and which of them can be tried at once.
module taut_constrained_coupling
   use taut_kinds, only: wp
   use taut_constrained_system, only: mechanical_system_t
   use taut_constrained_system_stiff, only: stiff_system_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_coloring, only: color_columns
   use taut_linalg_csr, only: csr_t
   implicit none (type, external)
   private
   public :: coupling_t

   !> The pattern of stiffness and damping matrices: symmetric, with its diagonal, row by row.
   type :: coupling_t
      !> First entry of each row, and the number of entries plus one at the end: (n + 1).
      integer, allocatable :: first(:)
      !> Column of each entry, ascending within a row.
      integer, allocatable :: column(:)
      !> Columns that no row has in common have the same color: (n).
      integer, allocatable :: color(:)
      !> Number of colors.
      integer :: colors = 0
   contains
      procedure :: init
      procedure :: place
      procedure :: add_elastic
   end type coupling_t

   !> A list that grows.
   type :: list_t
      integer :: count = 0
      integer, allocatable :: of(:)
   end type list_t

contains

   !> Finds the pattern of a system: what its forces couple, its constraints, its elastic rows and its masses.
   subroutine init(self, model)
      !> The pattern.
      class(coupling_t), intent(out) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      type(list_t), allocatable :: with(:)
      integer, allocatable :: first(:), column(:)
      integer :: b, i, j, n

      n = model%n
      select type (model)
      class is (stiff_system_t)
         call model%coupling(first, column)
      end select
      ! The other states may depend on every velocity, so that each has to be tried by itself.
      if (.not. allocated(first) .or. model%n_w > 0) then
         self%first = [(i*n + 1, i=0, n)]
         self%column = [((j, j=1, n), i=1, n)]
         self%color = [(i, i=1, n)]
         self%colors = n
         return
      end if
      allocate (with(n))
      do i = 1, n
         call join(with, [i])
         do j = first(i), first(i + 1) - 1
            call join(with, [i, column(j)])
         end do
      end do
      block
         integer, allocatable :: begin(:), of(:)

         call model%pattern(begin, of)
         if (.not. allocated(begin)) then
            begin = [(j*n + 1, j=0, min(model%c, 1))]
            of = [(j, j=1, n)]
         end if
         call join_rows(begin, of)
         select type (model)
         class is (stiff_system_t)
            call model%elastic_pattern(begin, of)
            call join_rows(begin, of)
         end select
      end block
      i = 0
      do b = 1, size(model%mass_blocks)
         call join(with, [(i + j, j=1, model%mass_blocks(b))])
         i = i + model%mass_blocks(b)
      end do
      call collect(with, self%first, self%column)
      allocate (self%color(n))
      call color_columns(self%first, self%column, self%color, self%colors)

   contains

      !> The columns of a row of A or B meet in the same force.
      subroutine join_rows(begin, of)
         integer, intent(in) :: begin(:), of(:)
         integer :: row

         do row = 1, size(begin) - 1
            call join(with, of(begin(row):begin(row + 1) - 1))
         end do
      end subroutine join_rows

   end subroutine init

   !> Couples all of a set with each other.
   pure subroutine join(with, set)
      type(list_t), intent(inout) :: with(:)
      integer, intent(in) :: set(:)
      integer, allocatable :: more(:)
      integer :: i, j

      do i = 1, size(set)
         associate (list => with(set(i)))
            if (.not. allocated(list%of)) allocate (list%of(8))
            do j = 1, size(set)
               if (any(list%of(:list%count) == set(j))) cycle
               if (list%count == size(list%of)) then
                  allocate (more(2*list%count))
                  more(:list%count) = list%of
                  call move_alloc(more, list%of)
               end if
               list%count = list%count + 1
               list%of(list%count) = set(j)
            end do
         end associate
      end do
   end subroutine join

   !> The lists as one, each in ascending order.
   pure subroutine collect(with, first, column)
      type(list_t), intent(in) :: with(:)
      integer, allocatable, intent(out) :: first(:), column(:)
      integer :: i, j, k, m

      allocate (first(size(with) + 1), column(sum(with%count)))
      first(1) = 1
      do i = 1, size(with)
         m = first(i)
         first(i + 1) = m + with(i)%count
         do j = 1, with(i)%count
            k = m + j - 1
            do while (k > m)
               if (column(k - 1) < with(i)%of(j)) exit
               column(k) = column(k - 1)
               k = k - 1
            end do
            column(k) = with(i)%of(j)
         end do
      end do
   end subroutine collect

   !> Where an entry of the pattern is; 0 if it has none there.
   pure integer function place(self, i, j)
      !> The pattern.
      class(coupling_t), intent(in) :: self
      !> Its row.
      integer, intent(in) :: i
      !> Its column.
      integer, intent(in) :: j
      integer :: high, low

      low = self%first(i)
      high = self%first(i + 1) - 1
      do while (low < high)
         place = (low + high)/2
         if (self%column(place) < j) then
            low = place + 1
         else
            high = place
         end if
      end do
      place = 0
      if (low > high) return
      if (self%column(low) == j) place = low
   end function place

   !> Adds the stiffness B^T k G of elastic rows, and the damping B^T k tau G.
   pure subroutine add_elastic(self, b, k, g, stiffness, tau, damping)
      !> The pattern.
      class(coupling_t), intent(in) :: self
      !> B, along the velocities.
      type(csr_t), intent(in) :: b
      !> Stiffnesses of the rows.
      type(block_diagonal_t), intent(in) :: k
      !> How the rows change along the velocities: B, or with what it changes by itself.
      type(csr_t), intent(in) :: g
      !> Entries in the pattern's order, added to.
      real(wp), intent(inout) :: stiffness(:)
      !> Time constants of the rows [s].
      real(wp), intent(in), optional :: tau(:)
      !> Entries of the damping, added to; with `tau`.
      real(wp), intent(inout), optional :: damping(:)
      integer :: block, entry, i, j, l, m, p
      real(wp) :: product

      entry = 0
      do block = 1, size(k%first) - 1
         do j = k%first(block), k%first(block + 1) - 1
            do i = k%first(block), k%first(block + 1) - 1
               entry = entry + 1
               if (.not. abs(k%values(entry)) > 0.0_wp) cycle
               do m = b%first(i), b%first(i + 1) - 1
                  do l = g%first(j), g%first(j + 1) - 1
                     p = self%place(b%column(m), g%column(l))
                     product = b%values(m)*k%values(entry)*g%values(l)
                     stiffness(p) = stiffness(p) + product
                     if (present(damping)) damping(p) = damping(p) + product*tau(j)
                  end do
               end do
            end do
         end do
      end do
   end subroutine add_elastic

end module taut_constrained_coupling
